"""Dry friction with mass, tendons, backlash. Inputs are shares of the range, -1..1 or 0..1.

Every function runs a mechanism along an input (T,), with its parameters in the order of the first line of its body;
samples come in steps h [s] that are as short as the mechanism needs.
"""

from __future__ import annotations

import math

import numpy as np

from zoo.compiled import Array, Parameters, compiled


@compiled
def sign(value: float) -> float:
    """Sign of a number, 0 of 0."""
    if value > 0.0:
        return 1.0
    if value < 0.0:
        return -1.0
    return 0.0


@compiled
def muscle_joint(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Two muscles against each other: late valves with choked flow, friction of the braid by pressure."""
    dead, flow, middle, braid, stribeck, viscous, contraction, rubber = p
    first_pressure, second_pressure, angle, speed, strained = middle, middle, 0.0, 0.0, 0.0
    y = np.empty(x.size)
    for k in range(x.size):
        late = max(k - dead / h, 0.0)
        whole = int(late)
        part = late - whole
        command = x[whole] + part * (x[min(whole + 1, x.size - 1)] - x[whole])
        # Flow grows with the root of a small difference and is choked above a large one.
        error = middle + 0.5 * command - first_pressure
        first_pressure += h * flow * sign(error) * min(math.sqrt(abs(error) * 0.6), 0.35)
        error = middle - 0.5 * command - second_pressure
        second_pressure += h * flow * sign(error) * min(math.sqrt(abs(error) * 0.6), 0.35)
        pull = first_pressure * (1.0 - contraction * angle) ** 2
        pull -= second_pressure * (1.0 + contraction * angle) ** 2
        force = pull - 0.3 * angle - 0.4 * angle**3 - rubber * (angle - strained)
        load = (
            first_pressure
            + second_pressure
            + 0.6 * abs(angle) * max(first_pressure, second_pressure)
        )
        dry = braid * load * (1.0 + stribeck * math.exp(-abs(speed) / 0.05))
        speed = sign(force) * max(abs(force) - dry, 0.0) / viscous
        angle += h * speed
        # The rubber yields with the logarithm of time.
        half = math.tanh(min(max((angle - strained) / 0.03, -18.0), 18.0)) * math.exp(-h / 4000.0)
        strained = angle - 0.015 * math.log((1.0 + half) / (1.0 - half))
        y[k] = angle
    return y


@compiled
def tendon(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Backlash, then a tendon around posts: friction grows exponentially with the angle, and that with the motion."""
    gap, pretension, stiffness, spring, mu, breakaway, angle_0, angle_1, viscous = p
    drum, tip, speed = x[0], x[0] * stiffness / (stiffness + spring), 0.0
    y = np.empty(x.size)
    for k, u in enumerate(x):
        drum = min(max(drum, u - gap), u + gap)
        tight = max(pretension + stiffness * (drum - tip), 0.0)
        slack = max(pretension - stiffness * (drum - tip), 0.0)
        rough = mu * (1.0 + breakaway * math.exp(-abs(speed) / 0.02))
        net = tight - slack - 2.0 * spring * tip
        ahead = 1.0 - math.exp(-rough * (angle_0 + angle_1 * max(tip, 0.0)))
        behind = 1.0 - math.exp(-rough * (angle_0 + angle_1 * max(-tip, 0.0)))
        dry = tight * ahead + slack * behind
        speed = sign(net) * max(abs(net) - dry, 0.0) / viscous
        tip += h * speed
        y[k] = tip
    return y


@compiled
def control_valve(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A diaphragm with air that lags, stem with mass against a spring, Karnopp's stiction of the packing."""
    air, choke, mass, static, coulomb, stribeck, viscous, jet = p
    pressure, stem, speed, still = x[0], x[0], 0.0, True
    y = np.empty(x.size)
    for k in range(x.size):
        # Filling is choked: the rate of the pressure has a limit.
        pressure += h * min(max((x[k] - pressure) / air, -choke), choke)
        force = pressure - stem - jet * stem * (1.0 - stem)
        if still and abs(force) <= static:
            y[k] = stem
            continue
        still = False
        way = sign(speed) if speed != 0.0 else sign(force)
        dry = coulomb + (static - coulomb) * math.exp(-((speed / stribeck) ** 2))
        before = speed
        speed += h * (force - way * dry - viscous * speed) / mass
        if before * speed < 0.0 or abs(speed) < 1e-6:
            speed, still = 0.0, True
        stem += h * speed
        # The stem ends at its seat and at its stop.
        if stem < -0.02 or stem > 1.02:
            stem, speed, still = min(max(stem, -0.02), 1.02), 0.0, True
        y[k] = stem
    return y


@compiled
def lugre_slide(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A slide with mass on bristles (LuGre), pulled by a force against a spring that stiffens."""
    mass, spring, cubic, bristle, damping, coulomb, static, stribeck, viscous = p
    place, speed, bent = 0.0, 0.0, 0.0
    y = np.empty(x.size)
    for k, u in enumerate(x):
        most = coulomb + (static - coulomb) * math.exp(-((speed / stribeck) ** 2))
        rate = speed - bristle * abs(speed) * bent / most
        drag = bristle * bent + damping * rate + viscous * speed
        speed += h * (u - spring * place - cubic * place**3 - drag) / mass
        bent += h * rate
        place += h * speed
        y[k] = place
    return y


@compiled
def cylinder(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A cylinder against a spring: choked flow into a chamber that grows, seals that drag by pressure, Stribeck."""
    flow, spring, preload, seal, by_pressure, breakaway, stribeck, viscous = p
    pressure, rod, speed = x[0], max(x[0] - preload, 0.0) / spring, 0.0
    y = np.empty(x.size)
    for k in range(x.size):
        command = x[k]
        # The command opens a valve in proportion; a sonic nozzle passes no more at a larger difference.
        opening = min(max(12.0 * (command - pressure), -1.0), 1.0)
        passed = flow * opening * (0.5 + 0.5 * min(1.0, 4.0 * abs(command - pressure)))
        pressure += h * (passed - pressure * 0.7 * speed) / (0.35 + rod)
        force = pressure - preload - spring * rod
        dry = (seal + by_pressure * max(pressure, 0.0)) * (
            1.0 + breakaway * math.exp(-abs(speed) / stribeck)
        )
        speed = sign(force) * max(abs(force) - dry, 0.0) / viscous
        if rod <= 0.0 and speed < 0.0:
            speed = 0.0
        rod += h * speed
        y[k] = rod
    return y


@compiled
def ageing_stage(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A stage on a leadscrew's spring: friction of rate and state (Dieterich, Ruina) that grows with time at rest."""
    stiffness, spring, level, direct, ageing, creep_speed, distance, tilt = p
    place, state, speed = x[0] * stiffness / (stiffness + spring), distance / creep_speed, 0.0
    y = np.empty(x.size)
    for k, u in enumerate(x):
        aged = level + ageing * math.log(1.0 + state * creep_speed / distance)
        aged *= 1.0 + tilt * place
        # Force over speed is a + b asinh(v), whose inverse is a sinh: solved by Newton, the spring included.
        pull = stiffness * (u - place) - spring * place
        for _ in range(12):
            drag = direct * math.asinh(speed / (2.0 * creep_speed) * math.exp(aged / direct))
            rate = direct / math.sqrt(
                speed * speed + (2.0 * creep_speed * math.exp(-aged / direct)) ** 2
            )
            missing = pull - (stiffness + spring) * h * speed - drag
            # A step must not leave the side of 0 on which the force pulls.
            new = speed + missing / ((stiffness + spring) * h + rate)
            if new * pull < 0.0:
                new = 0.1 * speed
            speed = new
        place += h * speed
        state += h * (1.0 - state * abs(speed) / distance)
        state = max(state, 1e-6)
        y[k] = place
    return y


@compiled
def spool(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A hydraulic positioner with mechanical feedback: overlap of the spool, flow by the root of pressure, seals."""
    overlap, gain, load, seal, breakaway, slip, leak = p
    rod, speed, hung = x[0], 0.0, x[0]
    y = np.empty(x.size)
    for k, u in enumerate(x):
        # The torque motor hangs by its friction.
        hung = min(max(hung, u - slip), u + slip)
        error = hung - rod
        opening = sign(error) * max(abs(error) - overlap, 0.0) + leak * error
        way = sign(opening)
        drag = seal * (1.0 + breakaway * math.exp(-abs(speed) / 0.1))
        drop = max(1.0 - way * (load * rod) - drag, 0.05)
        speed = gain * opening * math.sqrt(drop)
        rod += h * speed
        y[k] = rod
    return y


@compiled
def gear(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A load with inertia behind teeth with a gap that hit and stick in grease; heat of the housing drifts the zero."""
    gap, stiffness, damping, inertia, spring, grease, dry, drift, warm = p
    place, speed, heat = x[0] * stiffness / (stiffness + spring), 0.0, 0.0
    y = np.empty(x.size)
    for k, u in enumerate(x):
        driver = (u - x[max(k - 1, 0)]) / h
        twist = u - place
        force = 0.0
        if abs(twist) > gap:
            deep = abs(twist) - gap
            # Hertz: teeth are harder the deeper they press; damping only while they touch.
            force = sign(twist) * stiffness * deep * (1.0 + 6.0 * deep)
            force += damping * (driver - speed)
        net = force - spring * place
        # Grease drags with less than the speed, dry friction is smooth near rest.
        drag = grease * sign(speed) * abs(speed) ** 0.6 + dry * math.tanh(speed / 0.002)
        speed += h * (net - drag) / inertia
        place += h * speed
        heat += h / warm * (abs(driver) - heat)
        y[k] = place + drift * heat
    return y


@compiled
def pinched_frame(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A timber frame pushed by a jack: Baber and Noori's pinching, in series with a spring; bolts wear their holes."""
    share, beta, gamma, power, pinch, place_of, spread, wear, series = p
    shift, z, loss = 0.0, 0.0, 0.0
    limit = (1.0 / (beta + gamma)) ** (1.0 / power)
    y = np.empty(x.size)
    for k, u in enumerate(x):
        force = share * shift + (1.0 - share) * z
        # Jack, hose and frame are springs in series: the shift follows as far as the force lets it.
        way = (u - shift - series * force) / (1.0 + series)
        way = min(max(way, -0.02), 0.02)
        loose = wear * (1.0 - math.exp(-loss))
        at = z * sign(way) - place_of * limit
        narrow = 1.0 - (pinch + loose) * math.exp(-((at / spread) ** 2))
        before = z
        rate = 1.0 - abs(z) ** power * (beta * sign(way * z) + gamma)
        z += narrow * rate * way
        shift += way
        loss += max(0.5 * (z + before) * way, 0.0) * 0.2
        y[k] = 0.35 * u + share * shift + (1.0 - share) * z
    return y


@compiled
def greased_drive(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A spring pulls a vane through thixotropic grease, whose structure breaks by shear and grows again at rest."""
    yielded, viscous, shear, grows, breaks, spring, cubic = p
    place, structure, speed = x[0] / (1.0 + spring), 1.0, 0.0
    y = np.empty(x.size)
    for k, u in enumerate(x):
        force = (u - place) - spring * place - cubic * place**3
        limit = yielded * structure
        over = max(abs(force) - limit, 0.0) / (viscous * (0.3 + structure))
        # Herschel and Bulkley: it thins with its rate.
        speed = sign(force) * over ** (1.0 / shear)
        speed = min(max(speed, -20.0), 20.0)
        place += min(max(h * speed, -0.5 * abs(force)), 0.5 * abs(force))
        structure += h * (grows * (1.0 - structure) - breaks * structure * abs(speed))
        structure = min(max(structure, 0.0), 1.0)
        y[k] = place
    return y


@compiled
def bowden(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A cable in a bent sheath: eighteen pieces in series, each drags by the pull that passes through it."""
    mu, pretension, stiffness, spring, viscous, breakaway = p
    count = 18
    q = np.zeros(count)
    piece = stiffness * count
    # At rest the cable has been pulled tight from its far end.
    y = np.empty(x.size)
    for k, u in enumerate(x):
        before = pretension + piece * (u - q[0])
        for i in range(count):
            after = pretension + spring * q[i]
            if i < count - 1:
                after = pretension + piece * (q[i] - q[i + 1])
            before, after = max(before, 0.0), max(after, 0.0)
            net = before - after
            dry = mu / count * 0.5 * (before + after)
            if abs(net) < dry * (1.0 + breakaway):
                excess = max(abs(net) - dry * (1.0 + breakaway * math.exp(-abs(net) / dry)), 0.0)
            else:
                excess = abs(net) - dry
            q[i] += h * sign(net) * excess / viscous
            before = after
        y[k] = q[count - 1]
    return y


@compiled
def regulator(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A pressure regulator: dead time of its electronics, poppet that sticks to its seat, choked filling, bleed."""
    dead, fill, bleed, sticking, dither, volume, jet = p
    pressure, poppet = x[0], 0.0
    y = np.empty(x.size)
    for k in range(x.size):
        late = max(k - dead / h, 0.0)
        whole = int(late)
        command = x[whole] + (late - whole) * (x[min(whole + 1, x.size - 1)] - x[whole])
        # The jet pulls the open poppet shut: the harder, the larger the pressure that it fills against.
        force = command - pressure - jet * poppet * (1.0 - 0.6 * pressure)
        limit = sticking * (1.0 + dither * pressure)
        # Shut, the poppet sticks; open, it follows.
        if poppet == 0.0:
            if abs(force) > limit:
                poppet = sign(force) * 0.15 * limit
        else:
            poppet += h / 0.004 * (force - 0.4 * limit * sign(poppet) - poppet)
            if poppet * force < 0.0 and abs(poppet) < 0.2 * limit:
                poppet = 0.0
        rate = fill if poppet > 0.0 else bleed
        head = (
            math.sqrt(max(1.3 - pressure, 0.02))
            if poppet > 0.0
            else math.sqrt(max(pressure, 0.0) + 0.02)
        )
        passed = rate * min(max(6.0 * poppet, -1.0), 1.0) * head
        pressure += h * passed / volume
        pressure = max(pressure, -0.01)
        y[k] = pressure
    return y
