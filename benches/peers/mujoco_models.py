"""Cases that are mechanisms, as MuJoCo models; the plane of a case is MuJoCo's plane of x and z."""

import mujoco
import numpy as np

SOFT = 'solref="{0} 1" solimp="0.9999 0.9999 0.001 0.5 2"'
"""The stiffest that the documentation allows: a time constant of two steps."""


def body(name, at, joints, mass, site, inside=""):
    """A point mass at `site`; MuJoCo wants some inertia."""
    inertia = max(2e-15, 1e-9 * mass)
    place = " ".join(repr(float(x)) for x in site)
    return (
        f'<body pos="{" ".join(repr(float(x)) for x in at)}">{joints}'
        f'<inertial pos="{place}" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>'
        f'<site name="{name}" pos="{place}"/>{inside}</body>'
    )


def tendons(names, ends, soft):
    spatial = "".join(
        f'<spatial name="{n}"><site site="{a}"/><site site="{b}"/></spatial>'
        for n, (a, b) in zip(names, ends)
    )
    equal = "".join(f'<tendon tendon1="{n}" {soft}/>' for n in names)
    return f"<tendon>{spatial}</tendon><equality>{equal}</equality>"


def ball(case, q, v, soft):
    centre = np.round(q - [0.6, 0.0, -0.8])
    off = q - centre
    return body("a", centre, '<joint type="ball"/>', 1.0, off), "", [], np.cross(off, v), ["a"], (0, 1, 2)


def double_pendulum(case, q, v, soft):
    hinge = '<joint type="hinge" axis="0 -1 0"/>'
    first, second = np.array([q[0], 0, q[1]]), np.array([q[2] - q[0], 0, q[3] - q[1]])
    inner = body("b", first, hinge, case.masses[2], second)
    return body("a", (0, 0, 0), hinge, case.masses[0], first, inner), "", [], [0, 0], ["a", "b"], (0, 2)


def rod_twice(case, q, v, soft):
    slides = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>'
    bob = '<site name="pivot" pos="0 0 0"/>' + body("a", (q[0], 0, q[1]), slides, 1.0, (0, 0, 0))
    return bob, tendons(["one", "two"], [("pivot", "a")] * 2, soft), [], v, ["a"], (0, 2)


def crank(case, q, v, soft):
    arm = body("a", (0, 0, 0), '<joint type="hinge" axis="0 -1 0"/>', 1.0, (q[0], 0, q[1]))
    slider = body("b", (q[2], 0, 0), '<joint type="slide" axis="1 0 0"/>', 1.0, (0, 0, 0))
    return arm + slider, tendons(["rod"], [("a", "b")], soft), [], [1.0, v[2]], ["a", "b"], (0, 2)


MODELS = {"ball": ball, "double pendulum": double_pendulum, "rod twice": rod_twice, "crank": crank}


def run(case, q, v, record):
    bodies, rest, _, speeds, sites, axes = MODELS[case.mujoco](case, q, v, SOFT.format(2 * case.h))
    gravity = "0 0 -1" if case.potential != 0 else "0 0 0"
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option integrator="RK4" timestep="{case.h}" gravity="{gravity}"/>'
        f"<worldbody>{bodies}</worldbody>{rest}</mujoco>"
    )
    data = mujoco.MjData(model)
    data.qvel[:] = speeds
    of = [model.site(name).id for name in sites]
    jacobian = np.zeros((3, model.nv))

    def show(t):
        mujoco.mj_forward(model, data)
        places, speeds = [], []
        for site in of:
            mujoco.mj_jacSite(model, data, jacobian, None, site)
            places.append(data.site_xpos[site][list(axes)])
            speeds.append((jacobian @ data.qvel)[list(axes)])
        n = len(case.variables)
        record(t, np.concatenate(places)[:n], np.concatenate(speeds)[:n])
        return np.concatenate(places)[:n], np.concatenate(speeds)[:n]

    at, going = show(0.0)
    assert np.allclose(at, q, atol=1e-6) and np.allclose(going, v, atol=1e-6), (
        "the model is another mechanism"
    )
    for i in range(case.steps):
        mujoco.mj_step(model, data)
        if any(w.number for w in data.warning):
            kinds = [mujoco.mjtWarning(k).name for k, w in enumerate(data.warning) if w.number]
            raise RuntimeError("warning " + ", ".join(kinds))
        show((i + 1) * case.h)
