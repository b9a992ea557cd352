# docker build -t frameout .
# docker run --rm -v frameout-kernels:/kernels -v "$PWD/results:/work/results" --user "$(id -u)" frameout bench --quick
FROM python:3.11-slim
WORKDIR /frameout
COPY constraints.txt pyproject.toml README.md LICENSE ./
COPY sim sim
COPY trackers trackers
COPY scenarios scenarios
COPY benchmarks benchmarks
RUN pip install --no-cache-dir -c constraints.txt ".[data,tune]"
# Any user may keep compiled kernels here; the volume keeps them between runs.
RUN mkdir --mode=1777 /kernels
ENV NUMBA_CACHE_DIR=/kernels
VOLUME /kernels
WORKDIR /work
ENTRYPOINT ["frameout"]
