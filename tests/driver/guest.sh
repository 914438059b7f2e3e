#!/bin/sh
# Process 1 of the guest that uml.py boots, in two lives.  The first sees the host's / through hostfs, read-only, lays
# a tmpfs overlay over it and moves in.  The second, called with "inside", loads modules and runs the command.
# What it echoes lands in the job's kernel.log; only the command writes to the caller's standard output (tty1).
set -u
PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
export PATH
modules=/usr/lib/uml/modules/$(uname -r)

power_off() {
    sync
    echo o > /proc/sysrq-trigger
    sleep 10
}

give_up() { # no result file means to the host: the guest failed, not the command
    echo "guest: $*"
    power_off
}

move_in() {
    mount -t proc proc /proc
    for word in $(cat /proc/cmdline); do
        case $word in job=*) job=${word#*=} ;; esac
    done
    insmod "$modules/kernel/fs/overlayfs/overlay.ko" || give_up "no overlay module"
    mount -t tmpfs -o mode=755,size=75% tmpfs /mnt || give_up "no tmpfs"
    root=/mnt/root
    mkdir /mnt/upper /mnt/work $root
    mount -t overlay overlay -o lowerdir=/,upperdir=/mnt/upper,workdir=/mnt/work $root || give_up "no overlay"
    mount -t proc proc $root/proc
    mount -t sysfs sysfs $root/sys
    mount -t devtmpfs devtmpfs $root/dev
    mkdir -p $root/dev/pts $root/dev/shm
    mount -t devpts -o mode=620,ptmxmode=666,gid=5 devpts $root/dev/pts
    mount -t tmpfs -o mode=1777 tmpfs $root/dev/shm
    mount -t tmpfs -o mode=755 tmpfs $root/run
    mkdir -p $root/lib/modules $root/run/lock $root/run/job
    ln -sfn "$modules" "$root/lib/modules/$(uname -r)" # where modprobe looks
    mount -t hostfs -o "$job" none $root/run/job || give_up "no job folder"
    while read -r folder; do
        mkdir -p "$root$folder"
        mount -t hostfs -o "$folder" none "$root$folder" || give_up "cannot write to $folder"
    done < "$job/writable"
    exec chroot $root /bin/sh /run/job/guest.sh inside
}

work() {
    hostname uml
    ip link set lo up
    stty -F /dev/tty1 -opost -echo
    for module in $(cat /run/job/modules); do
        modprobe "$module" || give_up "no module $module"
    done
    sh -e /run/job/setup.sh || give_up "the setup failed"
    setsid -w sh /run/job/command.sh < /dev/null > /dev/tty1 2>&1
    echo $? > /run/job/result
    stty -F /dev/tty1 -a > /dev/null # returns when the console has written everything
    power_off
}

if [ "${1-}" = inside ]; then work; else move_in; fi
