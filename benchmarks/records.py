"""Rows: the one thing every table, plot and page is made from.

``records.jsonl`` holds one JSON object a line. Every row has these keys:

======================  ================================================================================
``suite``               ``frame-out``
``scenario``            catalogue id with version, ``road-town-v1``
``preset``              ``standard`` …
``tracker``, ``role``   registry name and its role (``ours`` ``variant`` ``as-written`` ``baseline`` ``oracle``)
``controller``          name of the controller that steered the camera; null where it flew a set path
``renderer``            ``raster`` or ``pybullet``
``seed``                the episode's seed
``repeat``              0; 0, 1, 2 for trackers that no seed makes reproducible and that are run again
``metric``              what ``value`` is, see below
``value``               a number; or a list of numbers (a *series*); null = undefined here (left out of means)
``weight``              how much the value counts in a mean over rows, e.g. the number of frames it is a mean of
``frame_out``           null for rows about the whole episode; else the frame-out that the row is about::

                            {"index": 0, "exit_frame": 57, "length_frames": 43, "back_frame": 104 or null,
                             "kind": "road" | "excursion", "side": "left"|"right"|"top"|"bottom",
                             "turned": true if it turned at a crossing while outside}

                        ``back_frame`` is the first frame on which the whole car is in the picture again; null if it left
                        again, or the episode ended, before that. ``length_frames`` counts frames wholly outside.
``seconds``             wall time of the episode with this tracker (not reproducible)
``versions``            of the packages, and short hashes of the code and the parameters that made the row
======================  ================================================================================

Rows of one (suite, scenario, preset, tracker, controller, renderer, seed) are one *block*, written at once. The last row of
a block has the metric ``frames`` (number of frames); a block without it was cut off, is ignored and made again.

Rows about one frame-out (suite ``frame-out``):

=================================  =====================================================================
``recovered``                      1 if on the car within 5 frames after ``back_frame``, else 0
``kept``                           1 if recovered and still on the car one second later, else 0
``recovery_frames``                frames from ``back_frame`` to the first one on the car; null = never
``watched_frames``                 frames from ``back_frame`` to the next exit or the episode's end: where
                                   ``recovery_frames`` is null the time to recover is censored here
``locked_on_wrong_car``            1 if on one other vehicle, not the target, in most of the frames
                                   ``back_frame`` … ``back_frame + 5``
``reentry_error_m``                error on the last frame wholly outside
``offscreen_error_30_m``, ``_100_m``  error 30 / 100 frames after the exit (only if it lasts that long)
``offscreen_error_by_frame_m``     *series*: error on each frame outside; entry k is k frames after the exit
=================================  =====================================================================

Frame-outs without a row ``recovered`` are those that cannot be judged: no full return to the picture before the next exit
or the end. (In closed loop the tracker steers: there a car that never returns is not recovered.)

Rows about the whole episode: ``coverage_50/90/95`` and ``nees`` (frames outside; null for a tracker without posterior),
``credible_level_histogram`` (*series* of 20: share of outside frames whose truth lay at level 0–5 %, 5–10 % … of the
posterior; flat = calibrated), ``offscreen_error_m``, ``offscreen_error_car_lengths``, ``in_view_tpr``, ``in_view_tnr``,
``precision_curve`` and ``recall_curve`` (*series* over ``metrics.long_term.THRESHOLDS``), ``centre_error_px``, ``success_auc``,
``success_curve`` (*series* over ``metrics.single_object.THRESHOLDS``), ``time_in_view`` and ``losses_per_minute``
(closed loop only), ``run_kept`` (1 if every frame-out that can be judged was kept), ``silent_frames``, ``ms_per_frame``,
``frames_per_s``, ``failed_at_frame`` (only if the tracker failed), ``frames``.

Beside ``records.jsonl`` a result directory holds ``summary.json`` (shape: DESIGN, "results"; entries of closed-loop runs carry
``controller`` too), ``comparisons.json`` (see ``benchmarks.summary``) and what the report writes.
"""
