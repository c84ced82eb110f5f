# Short names for what is done often. `just` lists them.

_default:
    @just --list

# everything that can be tested without hardware
test *ARGS:
    cargo test {{ARGS}}

# formatting and lints of all crates
lint:
    .ci/run formatting lints

# virtual boards in the live view
sim BOARDS="3":
    cargo run --release --bin pneudrive-host -- --port sim --devices {{BOARDS}} --command 100

# the firmware for the RP2040
firmware:
    cargo fw-build

# UF2 files for BOOTSEL
uf2:
    cargo fw-uf2

# the API's documentation
doc:
    cargo doc --no-deps --open

# the book of docs/, in target/book
book:
    mdbook build

# Once: rustup component add llvm-tools; cargo install cargo-llvm-cov. Of one crate: just coverage
# -p pneudrive-protocol.
# which lines the tests run, as pages in target/llvm-cov/html
coverage *ARGS:
    cargo llvm-cov --html {{ARGS}}

# what a release holds, in target/dist
dist *PARTS:
    dist/make {{PARTS}}

# what continuous integration does, or parts of it
ci *PARTS:
    .ci/run {{PARTS}}
