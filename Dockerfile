# A small image with lanewright alone: docker run --rm -v "$PWD:/maps" lanewright check map
FROM rust:1-bookworm AS build
WORKDIR /source
RUN apt-get update \
    && apt-get install -y --no-install-recommends cmake=3.* g++=4:* libsqlite3-dev=3.* pkg-config=1.* sqlite3=3.* \
    && rm -rf /var/lib/apt/lists/*
COPY . .
RUN cargo install --locked --path . --root /install

FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends libsqlite3-0=3.* libstdc++6=12.* \
    && rm -rf /var/lib/apt/lists/*
COPY --from=build /install/bin/lanewright /usr/local/bin/lanewright
COPY --from=build /source/NOTICE /source/LICENSE-MIT /source/LICENSE-APACHE /usr/share/doc/lanewright/
WORKDIR /maps
USER 65534:65534
ENTRYPOINT ["lanewright"]
CMD ["--help"]
