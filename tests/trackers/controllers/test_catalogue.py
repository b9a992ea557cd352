"""Controllers by name and carrier."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from typing import Any

import pytest

from trackers.controllers import catalogue
from trackers.controllers.catalogue import controller_entry, register_controller, steers_instead
from trackers.controllers.centring import CentreController
from trackers.registry import NoParameters
from trackers.types import CameraCommand


@pytest.mark.parametrize("answer", [(1.0, 2.0), None, CameraCommand])
def test_an_answer_of_a_user_s_controller_that_is_no_command_is_named(answer: Any) -> None:
    steer = _made(lambda: answer)
    with pytest.raises(TypeError, match=rf"command: expected a CameraCommand, got {type(answer).__name__}"):
        steer.command(None, None)


def test_a_user_s_controller_that_exits_fails_like_one_that_raises() -> None:
    with pytest.raises(RuntimeError, match=r"it called sys.exit\(3\)"):
        _made(lambda: sys.exit(3)).command(None, None)
    assert _made(lambda: CameraCommand(1.0)).command(None, None) == CameraCommand(1.0)


def test_a_class_without_a_command_is_no_controller() -> None:
    class Silent:
        Parameters = NoParameters

    with pytest.raises(ValueError, match="command: expected a method of this name in class Silent, got none"):
        register_controller("test_silent", role="external", carrier="test-carrier", summary="")(Silent)


def test_a_controller_that_inherits_has_not_the_kernel_of_another() -> None:
    class Slower(CentreController):
        def command(self, observation: Any, estimate: Any) -> Any:
            return CameraCommand(0.5 * super().command(observation, estimate).forward_mps)

    register_controller("test_slower", role="external", carrier="test-carrier", summary="")(Slower)
    try:
        assert controller_entry("test_slower", "test-carrier").kernel is None
        assert controller_entry("centre", "helicopter").kernel is CentreController.KERNEL
    finally:
        del catalogue._ENTRIES["test-carrier", "test_slower"]


def _made(answer: Callable[[], Any]) -> Any:
    """Return a user's controller that answers so."""

    class Own:
        Parameters = NoParameters

        def __init__(self, parameters: NoParameters) -> None:
            pass

        def command(self, observation: Any, estimate: Any) -> Any:
            return answer()

    register_controller("test_own", role="external", carrier="test-carrier", summary="a user's")(Own)
    try:
        return controller_entry("test_own", "test-carrier").create()
    finally:
        del catalogue._ENTRIES["test-carrier", "test_own"]


def test_a_controller_of_another_carrier_is_told_what_it_steers() -> None:
    assert steers_instead("reentry") == ", which steers a helicopter or a robot"
    assert steers_instead("nobody") == ""
    own = "one of your own is known when its module is imported"
    for name, near in (("rentry", " (did you mean reentry?)"), ("re", " (did you mean reentry?)"), ("nobody", "")):
        with pytest.raises(ValueError, match=re.escape(f"got {name!r}{near}; {own}")):
            controller_entry(name, "robot")
    with pytest.raises(ValueError, match=r"got 'reentry', which steers a helicopter or a robot$"):
        controller_entry("reentry", "tank-head")
