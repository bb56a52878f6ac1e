# A small image with lanewright alone: docker run --rm -v "$PWD:/maps" lanewright check map
# It installs the wheel that lies in dist/ (`make wheel`, or one of a release); where there is none, it builds one.
FROM rust:1-bookworm AS wheel
WORKDIR /source
COPY . .
RUN ls dist/*.whl >/dev/null 2>&1 || make wheel

FROM python:3-slim-bookworm
COPY --from=wheel /source/dist/*.whl /tmp/
RUN pip install --no-cache-dir --disable-pip-version-check /tmp/lanewright-*.whl && rm /tmp/lanewright-*.whl
COPY NOTICE LICENSE-MIT LICENSE-APACHE /usr/share/doc/lanewright/
WORKDIR /maps
USER 65534:65534
ENTRYPOINT ["lanewright"]
CMD ["--help"]
