# The environment of environment.lock with the checkout in it:
#   docker build -t cmtof . && docker run --rm -p 8888:8888 cmtof
FROM python:3.11-slim-bookworm
SHELL ["/bin/bash", "-euo", "pipefail", "-c"]
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends chromium g++ git libegl1 libgl1 make \
    && rm -rf /var/lib/apt/lists/*
RUN useradd --create-home reader
USER reader
WORKDIR /home/reader/cmtof
COPY --chown=reader . .
RUN make setup
EXPOSE 8888
CMD [".venv/bin/jupyter", "lab", "--ip=0.0.0.0", "--ServerApp.root_dir=.", "notebooks"]
