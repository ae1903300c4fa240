"""Peers that cannot be given the billiard, for `accuracy.py`: MuJoCo and Drake on a pendulum, LAMMPS on a torus.

The scenes, their 30-digit references and T = 5 are those of `examples/accuracy`: a pendulum of unit length let go from
the horizontal, and a geodesic on the torus with radii 1 and 0.3 that leaves its equator at 30°.
"""

import os
import re
import subprocess
import tempfile
from pathlib import Path

import lammps_input
import numpy as np

T = 5.0


def place(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def mujoco(method):
    """A hinge, so that the rod holds exactly; contacts and constraints off; all steps in one call."""

    def make():
        import mujoco as m

        model = m.MjModel.from_xml_string(
            f"""<mujoco><option gravity="0 0 -1" integrator="{method}"><flag contact="disable" constraint="disable"/>
            </option><worldbody><body><joint type="hinge" axis="0 -1 0"/>
            <inertial pos="1 0 0" mass="1" diaginertia="1e-15 1e-15 1e-15"/></body></worldbody></mujoco>"""
        )
        data = m.MjData(model)

        def run(_, h):
            steps = round(T / h)
            model.opt.timestep = T / steps
            m.mj_resetData(model, data)
            m.mj_step(model, data, steps)
            return place(data.qpos[0])

        return run

    return make


def drake(method, fixed):
    """A revolute joint of a continuous plant; a `fixed` step, or a step that holds the accuracy."""

    def make():
        from pydrake.multibody.plant import MultibodyPlant
        from pydrake.multibody.tree import RevoluteJoint, SpatialInertia, UnitInertia
        from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

        plant = MultibodyPlant(0.0)
        bob = plant.AddRigidBody("bob", SpatialInertia(1.0, [1.0, 0.0, 0.0], UnitInertia(0.0, 1.0, 1.0)))
        hinge = RevoluteJoint("hinge", plant.world_frame(), bob.body_frame(), [0.0, -1.0, 0.0], 0.0)
        joint = plant.AddJoint(hinge)
        plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -1.0])
        plant.Finalize()
        simulator = Simulator(plant)
        context, was = simulator.get_mutable_context(), None

        def run(_, setting):
            nonlocal was
            if setting != was:
                integrator = ResetIntegratorFromFlags(simulator, method, setting if fixed else 0.5)
                if fixed:
                    integrator.set_fixed_step_mode(True)
                else:
                    integrator.set_target_accuracy(setting)
                was = setting
            context.SetTime(0.0)
            joint.set_angle(context, 0.0)
            joint.set_angular_rate(context, 0.0)
            simulator.Initialize()
            simulator.AdvanceTo(T)
            return place(joint.get_angle(context))

        return run

    return make


def lammps():
    """`fix nve/manifold/rattle` of the program that `lammps.sh` builds; it times itself, over 100 000 further steps."""
    program = os.environ.get("LAMMPS", "lmp_serial")
    try:
        told = subprocess.run([program, "-h"], capture_output=True, text=True).stdout
    except FileNotFoundError:
        raise ImportError("no such program; see lammps.sh") from None
    if "nve/manifold/rattle" not in told:
        raise ImportError("this one is built without MANIFOLD; see lammps.sh")

    def run(start, h):
        steps = round(T / h)
        more = f"""timestep {T / steps!r}\nrun {steps}
            write_dump all custom end.txt x y z modify format float %.17g\nrun 100000"""
        with tempfile.TemporaryDirectory() as folder:
            lammps_input.write(Path(folder), start[:3], start[3:], "1e-14 100 torus 1.0 0.3", more)
            done = subprocess.run(
                [program, "-in", "in.txt", "-log", "none"], cwd=folder, capture_output=True, text=True
            )
            if done.returncode:
                raise RuntimeError((done.stdout + done.stderr).strip().splitlines()[-1])
            end = np.array([float(x) for x in (Path(folder) / "end.txt").read_text().split()[-3:]])
        loop = re.findall(r"Loop time of (\S+) on .* for 100000 steps", done.stdout)[-1]
        busy = re.findall(r"([\d.]+)% CPU use", done.stdout)[-1]
        run.seconds = float(loop) * float(busy) / 100 / 100_000 * steps
        return end

    return run
