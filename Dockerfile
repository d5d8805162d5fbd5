# Three images, which need BuildKit:
#
#   docker build --target supervisor -t vibrissa .
#   docker build --target lab -t vibrissa-lab .              # simulated robots, and vibrissa-lab beside them
#   docker build --target robot -t vibrissa-robot .          # docs/agent.md says how to run it

# Sources of the base images.
ARG RUST_IMAGE=rust:1.95-slim-bookworm
ARG DEBIAN_IMAGE=debian:bookworm-slim

FROM ${RUST_IMAGE} AS source
WORKDIR /src
COPY . .

# Each image compiles its own program only. The cache keeps built dependencies, but is not part of a layer: hence the
# programs are copied out of it.
FROM source AS build-supervisor
RUN --mount=type=cache,target=/usr/local/cargo/registry,sharing=locked \
    --mount=type=cache,target=/src/target,sharing=locked \
    cargo build --profile dist --locked -p vibrissa --features full \
    && install -D -t /out target/dist/vibrissa

FROM source AS build-lab
RUN --mount=type=cache,target=/usr/local/cargo/registry,sharing=locked \
    --mount=type=cache,target=/src/target,sharing=locked \
    cargo build --profile dist --locked -p vibrissa-lab -p vibrissa-simulator --features vibrissa-lab/full --bins \
    && install -D -t /out target/dist/vibrissa-lab target/dist/vibrissa-simulator

FROM source AS build-robot
RUN --mount=type=cache,target=/usr/local/cargo/registry,sharing=locked \
    --mount=type=cache,target=/src/target,sharing=locked \
    cargo build --profile dist --locked --manifest-path robot/Cargo.toml -p vibrissa-robot --target-dir target \
    && install -D -t /out target/dist/vibrissa-robot

FROM ${DEBIAN_IMAGE} AS runtime
# A named volume that is mounted here takes over the folder's owner.
RUN useradd --uid 10001 --user-group --no-create-home --home-dir /var/lib/vibrissa --shell /usr/sbin/nologin vibrissa \
    && install -d -o vibrissa -g vibrissa /var/lib/vibrissa
WORKDIR /var/lib/vibrissa
USER 10001:10001

FROM runtime AS lab
LABEL org.opencontainers.image.title="vibrissa-lab" \
      org.opencontainers.image.description="A fleet of simulated whisker robots, and the laboratory's program" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build-lab /out/vibrissa-lab /out/vibrissa-simulator /usr/local/bin/
COPY lab/simulator/scenarios /usr/share/vibrissa/scenarios
ENV VIBRISSA_SCENARIO=/usr/share/vibrissa/scenarios/example.toml
ENTRYPOINT ["vibrissa-simulator"]

FROM runtime AS robot
LABEL org.opencontainers.image.title="vibrissa-robot" \
      org.opencontainers.image.description="The agent of a robot with soft whisker arrays" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build-robot /out/vibrissa-robot /usr/local/bin/
ENTRYPOINT ["vibrissa-robot"]
CMD ["--config", "/etc/vibrissa/agent.toml"]

FROM runtime AS supervisor
LABEL org.opencontainers.image.title="vibrissa" \
      org.opencontainers.image.description="Supervisor for fleets of robots with soft whisker arrays" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0"
COPY --from=build-supervisor /out/vibrissa /usr/local/bin/
COPY deploy/supervisor/readyz.sh /usr/local/bin/vibrissa-readyz
ENV VIBRISSA_DATABASE_URL=sqlite:/var/lib/vibrissa/vibrissa.sqlite3 \
    VIBRISSA_HTTP_LISTEN=0.0.0.0:8080 \
    VIBRISSA_HTTP_MONITORING_LISTEN=0.0.0.0:9464
# 9464 serves /livez, /readyz and /metrics without a token: publish it only to monitoring.
EXPOSE 8080 9464
HEALTHCHECK --interval=10s --timeout=5s --start-period=30s --retries=3 CMD ["vibrissa-readyz"]
ENTRYPOINT ["vibrissa"]
CMD ["run"]
