#!/bin/sh
# Start a Slurm of four nodes on this machine, with its files in an empty folder; end it:
#   slurm.sh start FOLDER    slurm.sh stop FOLDER
# It needs root, Debian's packages and free ports; without them the status is 77.
# The configuration is in /etc, since a nested srun of Snakemake's plugin reads no other.
set -eu
config=/etc/slurm/slurm.conf
folder=$2

skip() {
  echo "make test-cluster: skipped, $1" >&2
  exit 77
}

stop() {
  scancel --user=root || true
  for _ in $(seq 30); do
    if [ -z "$(squeue --noheader)" ]; then break; else sleep 1; fi
  done
  for file in "$folder"/*.pid; do
    kill "$(cat "$file")" || true
  done
  rm "$config"
}

start() {
  [ "$(id -u)" = 0 ] || skip "not root; run it as root"
  if ! { command -v slurmctld && command -v munged; } >/dev/null; then
    apt-get install -y --no-install-recommends slurm-wlm munge >/dev/null 2>&1 ||
      skip "no slurm-wlm and munge; install them"
  fi
  [ ! -e "$config" ] || skip "$config belongs to another Slurm; use another machine"
  for port in $(seq 16820 16824); do
    python3 -c "import socket; socket.create_server(('', $port), reuse_port=False)" 2>/dev/null ||
      skip "port $port is taken; free it"
  done
  trap stop EXIT
  mkdir -p "$folder/state" "${config%/*}"
  sed "s|FOLDER|$folder|; s|HOST|$(hostname)|" "${0%.sh}.conf" >"$config"
  (umask 077 && head -c 64 /dev/urandom >"$folder/munge.key")
  munged --force --key-file="$folder/munge.key" --log-file="$folder/munge.log" \
    --seed-file="$folder/munge.seed" --pid-file="$folder/munged.pid" \
    --socket="$folder/munge.socket"
  slurmctld
  for node in n1 n2 n3 n4; do
    mkdir -p "$folder/spool/$node"
    slurmd -N "$node"
  done
  for _ in $(seq 30); do
    if [ "$(sinfo --noheader --format='%T %D')" = "idle 4" ]; then
      trap - EXIT
      return
    fi
    sleep 1
  done
  skip "no node starts; see $folder"
}

"$1"
