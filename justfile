# Menu of the developer: `just` lists it. Each recipe is one command that also works alone.

[private]
default:
    @{{ just_executable() }} --list --unsorted

# See the whole system work in half a minute
demo *options:
    cargo run --release --locked -- demo {{ options }}

# Run all checks: format, supply chain, lints, all tests (half an hour and more)
test:
    tests/run

# Run one suite of tests/Cargo.toml, such as deploy or http, or some of its tests
suite name *tests:
    cargo test --locked -p vibrissa-tests --test {{ name }} -- {{ tests }}

# Run the tests of a crate, such as core, core-tests, protocol, store or simulator
crate name *tests:
    cargo test --locked -p vibrissa-{{ name }} -- {{ tests }}

# Run the tests of the robot's programs
robot *tests:
    cargo test --manifest-path robot/Cargo.toml --target-dir target/robot --workspace --exclude vibrissa-robot-python -- {{ tests }}

# Fail servers and attack them for a minute; everything must be recorded once
chaos *options="--seed 1 --seconds 60":
    cargo run --release --locked -p vibrissa-tests --bin chaos -- {{ options }}

# Run before a release what takes hours: simulated days, long chaos, its controls, containers
release *options:
    tests/release {{ options }}

# Measure throughput, latency, CPU and memory; --quick takes two minutes
benchmark *options:
    tests/bench {{ options }}

# Start docker-compose.yml with images of Debian's packages, and check it
compose *options:
    tests/compose {{ options }}

# Format the code
format:
    cargo fmt
    cargo fmt --manifest-path robot/Cargo.toml

# Show the lints as tests/run wants them
lints:
    cargo clippy --workspace --all-targets --locked -- -D warnings

# Write the generated documents of the contract, webhooks and events
documents:
    VIBRISSA_WRITE_DOCS=1 cargo test --workspace --lib --locked -- in_docs the_document_says

# Write the list of metrics
metrics:
    cargo run --locked --features full -- metrics > docs/metrics.md

# Build the documents as a site with a search in target/book/html
book:
    docs/make-book

# Build the documentation of core and contract from their comments
rustdoc:
    RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps -p vibrissa-core -p vibrissa-protocol
