# docker build -t warmlink . && docker run --rm -v "$PWD:/work" warmlink run
FROM python:3.11-slim-bookworm
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
COPY . /src
RUN pip install --no-cache-dir --constraint /src/constraints.txt "/src[studies]"
WORKDIR /work
ENTRYPOINT ["warmlink"]
CMD ["--help"]
