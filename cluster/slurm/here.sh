#!/usr/bin/env bash
# A SLURM of one node, this machine, to try the profile on. Debian's slurm-wlm and munge, as root.
#   cluster/slurm/here.sh start | stop        state and logs: /tmp/cmtof_slurm
set -euo pipefail
STATE=/tmp/cmtof_slurm
CONF=/etc/slurm/slurm.conf
NODE=$(hostname -s)

stop() {
  local name
  for name in slurmd slurmctld munged; do
    if [ -s "$STATE/$name.pid" ]; then
      kill "$(cat "$STATE/$name.pid")" 2>/dev/null || true
      rm -f "$STATE/$name.pid"
    fi
  done
  ! grep -qs "$STATE" "$CONF" || rm "$CONF"
}

start() {
  command -v slurmctld slurmd munged >/dev/null ||
    { echo "Expected slurmctld, slurmd and munged, got none. apt-get install slurm-wlm munge" >&2; exit 1; }
  if [ -e "$CONF" ] && ! grep -q "$STATE" "$CONF"; then
    echo "Expected no $CONF of another cluster, got one. Leave this machine as it is." >&2; exit 1
  fi
  mkdir -p "$STATE"/{ctld,d} /run/munge
  chown munge:munge /run/munge
  chmod 755 "$STATE" /run/munge
  cat >"$CONF" <<END
ClusterName=here
SlurmctldHost=$NODE(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
StateSaveLocation=$STATE/ctld
SlurmdSpoolDir=$STATE/d
SlurmctldPidFile=$STATE/slurmctld.pid
SlurmdPidFile=$STATE/slurmd.pid
SlurmctldLogFile=$STATE/slurmctld.log
SlurmdLogFile=$STATE/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobCompType=jobcomp/filetxt
JobCompLoc=$STATE/jobs.txt
MpiDefault=none
ReturnToService=2
NodeName=$NODE NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=8000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
END
  munged --force --pid-file="$STATE/munged.pid" 2>/dev/null
  slurmctld
  slurmd
}

case ${1:-} in
  start | stop) "$1" ;;
  *) echo "usage: $0 start|stop" >&2; exit 2 ;;
esac
