"""What LAMMPS is given to hold one particle on a manifold, for `tools.py` and `others.py`."""


def write(folder, q, v, constraint, more):
    """Writes `in.txt`: a particle at q with velocity v, unit mass and no force, that `fix nve/manifold/rattle` holds
    with this tolerance, number of iterations and manifold; then the commands of the caller."""
    script = f"""
        units lj\natom_style atomic\natom_modify sort 0 0\nboundary f f f
        neigh_modify delay 0 every 100000000 check no
        region box block -3 3 -3 3 -3 3\ncreate_box 1 box
        create_atoms 1 single {" ".join(repr(float(x)) for x in q)} units box\nmass 1 1.0
        velocity all set {" ".join(repr(float(x)) for x in v)} units box
        pair_style zero 0.1 nocoeff\npair_coeff * *\nthermo_modify norm no\nthermo 100000000
        fix hold all nve/manifold/rattle {constraint}
        {more}
        """
    (folder / "in.txt").write_text("\n".join(line.strip() for line in script.splitlines()))
