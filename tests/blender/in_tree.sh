#!/bin/bash
# in_tree.sh TREE SHARED COMMAND...: runs COMMAND as root in the system tree TREE, which sees the folder SHARED as /share.
# The mounts live in a namespace of this command alone and vanish with it: removing TREE can never reach the host's /dev.
exec unshare --mount --propagation private bash -euc '
tree=$1 shared=$2; shift 2
mkdir -p "$tree/share"
mount -t proc proc "$tree/proc"
mount --bind /dev "$tree/dev"
mount --bind /dev/shm "$tree/dev/shm"
mount --bind "$shared" "$tree/share"
exec chroot "$tree" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
    DEBIAN_FRONTEND=noninteractive BLENDER_USER_RESOURCES=/share/user "$@"
' in_tree.sh "$@"
