# Pavescape in a container. UNTESTED: no container was built from it.
#     docker build -t pavescape .
#     docker run --rm -v "$PWD:/work" -u "$(id -u):$(id -g)" pavescape fit road.toml
# `explore` listens on the container's own 127.0.0.1: run it with --network host.
FROM debian:12 AS build
COPY . /source
WORKDIR /source
RUN tools/setup --tests release \
    && cmake -B build/release -DPAVESCAPE_NATIVE=OFF -DBUILD_TESTING=OFF \
    && cmake --build build/release \
    && cpack --config build/release/CPackConfig.cmake -B /package

FROM debian:12
COPY --from=build /package/*.deb /package/
RUN apt-get update \
    && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends gnuplot-nox fonts-liberation /package/*.deb \
    && rm -rf /var/lib/apt/lists/* /package
WORKDIR /work
ENTRYPOINT ["pavescape"]
