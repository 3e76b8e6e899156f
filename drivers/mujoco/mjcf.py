"""MJCF, the model as MuJoCo reads it, of a chain.

Elements and attributes are those of MuJoCo's XML reference. What MJCF has no element for is not in the file: drag
quadratic in the links' own axes, which `robot.MujocoRobot` applies in every step.
"""

from tendond.drivers.mujoco.chain import Chain, Link

FORCE_MAX = 1e4
"""Largest tension of a winch [N], beyond any that a robot bears: a winch must pull only, which needs a range."""


def mjcf(chain: Chain) -> str:
    """Return the chain as MJCF.

    Bodies are link0 to linkN and tip_mass, which is empty for a load at run time; tendons t0 to tn; actuators: for each
    tendon a motor by tension [N], then for each a winch by the tendon's length [m], slack where that is longer.
    """
    by_link: dict[int, list[str]] = {link: [] for link in range(-1, len(chain.links))}
    tendons = ""
    for index, tendon in enumerate(chain.tendons):
        through = ""
        for number, s in enumerate(chain.sites(tendon)):
            owner = chain.owner(s)
            x, y = tendon.at(s)
            name = f"t{index}_{number}"
            by_link[owner].append(f'<site name="{name}" pos="{x!r} {y!r} {s - chain.begin(owner)!r}"/>')
            through += f'<site site="{name}"/>'
        tendons += f'    <spatial name="t{index}">{through}</spatial>\n'
    worldbody = _indented(by_link[-1], 2)
    for index, link in enumerate(chain.links):
        worldbody += _link(chain, index, link)
        worldbody += _indented(by_link[index], 3)
        worldbody += _indented(_weights(chain, index), 3)
    tip = chain.reach(len(chain.links) - 1)
    worldbody += (
        f'      <body name="tip_mass" pos="0 0 {tip!r}"><inertial pos="0 0 0" mass="1e-12" '
        'diaginertia="1e-18 1e-18 1e-18"/><site name="tip"/></body>\n'
    )
    worldbody += "    " + "</body>" * len(chain.links) + "\n"
    motors = "".join(f'    <motor tendon="t{index}" gear="-1"/>\n' for index in range(len(chain.tendons)))
    winches = "".join(
        f'    <position tendon="t{index}" kp="{tendon.stiffness!r}" forcelimited="true" '
        f'forcerange="{-FORCE_MAX!r} 0"/>\n'
        for index, tendon in enumerate(chain.tendons)
    )
    speeds = "".join(f'    <velocimeter site="centre{index}"/>\n' for index in range(len(chain.links)))
    x, y, z = chain.gravity
    return (
        '<mujoco model="tendond">\n  <compiler angle="radian"/>\n'
        f'  <option timestep="{chain.step!r}" integrator="implicitfast" gravity="{x!r} {y!r} {z!r}">'
        '<flag contact="disable" constraint="disable" autoreset="disable"/></option>\n'
        f"  <worldbody>\n{worldbody}  </worldbody>\n  <tendon>\n{tendons}  </tendon>\n"
        f"  <actuator>\n{motors}{winches}  </actuator>\n  <sensor>\n{speeds}  </sensor>\n</mujoco>\n"
    )


def _link(chain: Chain, index: int, link: Link) -> str:
    """Return the opening of a link's body, with joint, mass and the site of its centre."""
    h, length = chain.spacing, chain.reach(index)
    mass = link.mass_per_length * length
    across = mass * length**2 / 12.0 + link.section_inertia * length
    place = chain.begin(index) - chain.begin(index - 1)
    return (
        f'    <body name="link{index}" pos="0 0 {place!r}">'
        f'<joint type="ball" stiffness="{link.bending_stiffness / h!r}" damping="{link.damping / h!r}"/>'
        f'<inertial pos="0 0 {length / 2.0!r}" mass="{mass!r}" diaginertia="{across!r} {across!r} '
        f'{2.0 * link.section_inertia * length!r}"/><site name="centre{index}" pos="0 0 {length / 2.0!r}"/>\n'
    )


def _weights(chain: Chain, index: int) -> list[str]:
    """Return the bodies that a link carries."""
    found = []
    for number, weight in enumerate(chain.weights):
        if chain.owner(weight.at) == index and weight.mass > 0.0:
            x, y, z = weight.offset
            inertia = " ".join(repr(max(one, 1e-18)) for one in weight.inertia)  # MuJoCo bears no body without any
            found.append(
                f'<body name="weight{number}" pos="{x!r} {y!r} {weight.at - chain.begin(index) + z!r}">'
                f'<inertial pos="0 0 0" mass="{weight.mass!r}" diaginertia="{inertia}"/></body>'
            )
    return found


def _indented(lines: list[str], depth: int) -> str:
    return "".join("  " * depth + line + "\n" for line in lines)
