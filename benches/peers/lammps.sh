#!/bin/sh
# LAMMPS with MANIFOLD from Debian's source, for accuracy.py:  lammps.sh FOLDER && export LAMMPS=FOLDER/lmp_serial
# Ten minutes on two cores. Neither Debian's liblammps0 of bookworm nor the wheel on PyPI is built with MANIFOLD.
set -eu
version=20220106.git7586adbb6a
mkdir -p "$1"
cd "$1"
curl -sSfLO "http://deb.debian.org/debian/pool/main/l/lammps/lammps_$version+ds1.orig.tar.xz"
echo "65146c615ad24d8b8bc64f4e05e86226a7f1fdb45c0b5ea9416562b9f3863082  lammps_$version+ds1.orig.tar.xz" | sha256sum -c
tar xf "lammps_$version+ds1.orig.tar.xz"
make -C "lammps-0~$version/src" yes-manifold
make -C "lammps-0~$version/src" -j2 CCFLAGS=-O2 serial
cp "lammps-0~$version/src/lmp_serial" .
