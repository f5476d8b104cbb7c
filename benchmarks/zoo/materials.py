"""Hysteresis of materials: domains, phases, trapped charge. Inputs are shares of the range, -1..1 or 0..1.

Every function runs a mechanism along an input (T,), with its parameters in the order of the first line of its body;
samples come in steps h [s] that are as short as the mechanism needs.
"""

from __future__ import annotations

import math

import numpy as np

from zoo.compiled import Array, Parameters, compiled

SETTLE = 5000  # steps at rest before the first sample


@compiled
def switched(states: Array, x: float, table: Array) -> float:
    """Switch relays (rows: up, down, weight) to an input; return the sum of their weighted states."""
    total = 0.0
    for i in range(table.shape[0]):
        if x >= table[i, 0]:
            states[i] = 1.0
        elif x <= table[i, 1]:
            states[i] = -1.0
        total += states[i] * table[i, 2]
    return total


@compiled
def demagnetised(x: float, table: Array, low: float) -> Array:
    """States of relays at rest: all down where the range begins at 0, else as after dying strokes around x."""
    states = np.full(table.shape[0], -1.0)
    if low < 0.0:
        for i in range(table.shape[0]):
            if 0.5 * (table[i, 0] + table[i, 1]) <= x:
                states[i] = 1.0
    return states


@compiled
def activated(distance: float, scale: float, ratio: float) -> float:
    """Distance left after a time of `ratio` tau of dz/dt = -(scale/tau) sinh(z/scale), Eyring's flow.

    It creeps with the logarithm of time, however long tau is.
    """
    half = math.tanh(min(max(0.5 * distance / scale, -18.0), 18.0)) * math.exp(-ratio)
    return scale * math.log((1.0 + half) / (1.0 - half))


@compiled
def piezo(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Relays, creep with the logarithm of time, and a resonance behind them."""
    low, line, share, scale, tau, frequency, damping = p
    states = demagnetised(x[0], table, low)
    v = line * x[0] + switched(states, x[0], table)
    crept, position, speed = share * v, v, 0.0
    w = 2.0 * math.pi * frequency
    y = np.empty(x.size)
    position += crept
    for k in range(x.size):
        v = line * x[k] + switched(states, x[k], table)
        crept = share * v - activated(share * v - crept, scale, h / tau)
        speed += h * (w * w * (v + crept - position) - 2.0 * damping * w * speed)
        position += h * speed
        y[k] = position
    return y


@compiled
def loaded_stack(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Relays whose field sinks with the load of a spring, and whose loops widen with it; the zero drifts with heat."""
    low, line, counter, widening, drift, hours = p
    states = demagnetised(x[0], table, low)
    y = np.empty(x.size)
    last = line * x[0]
    for k in range(x.size):
        field = x[k] - counter * last
        width = 1.0 + widening * last
        total = 0.0
        for i in range(table.shape[0]):
            middle = 0.5 * (table[i, 0] + table[i, 1])
            half = 0.5 * (table[i, 0] - table[i, 1]) * width
            if field >= middle + half:
                states[i] = 1.0
            elif field <= middle - half:
                states[i] = -1.0
            total += states[i] * table[i, 2]
        # The load of the last moment counts, smoothed, so that a switch does not undo itself.
        last += 0.5 * (line * x[k] + total - last)
        y[k] = last + drift * math.sin(k * h / (3600.0 * hours))
    return y


@compiled
def eddied(field: float, applied: float, h: float, classical: float, excess: float) -> float:
    """Field inside after a time h: it lags by eddy currents, classical ones with its rate and excess with its root."""
    missing = abs(applied - field)
    root = (-excess + math.sqrt(excess * excess + 4.0 * classical * missing)) / (2.0 * classical)
    step = min(h * root * root, missing)
    if applied < field:
        return field - step
    return field + step


@compiled
def magnetostriction(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Jiles and Atherton's magnetisation squared, behind eddy currents."""
    shape, coupling, pinning, reversible, classical, excess = p
    irreversible, m, field = 0.0, 0.0, x[0]
    y = np.empty(x.size)
    for k in range(x.size):
        before = field
        field = eddied(field, x[k], h, classical, excess)
        change = field - before
        effective = (field + coupling * m) / shape
        anhysteretic = effective / 3.0
        if abs(effective) > 1e-3:
            anhysteretic = 1.0 / math.tanh(effective) - 1.0 / effective
        way = 1.0 if change >= 0.0 else -1.0
        missing = anhysteretic - irreversible
        # A wall that would move against the field stays where it is.
        if missing * way > 0.0:
            irreversible += change * missing / (pinning * way - coupling * missing)
        m = reversible * anhysteretic + (1.0 - reversible) * irreversible
        y[k] = m * m
    return y


@compiled
def elastomer(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Maxwell's stress, V squared, stretches a film that softens; two networks yield by Eyring's flow."""
    soft, share, scale, tau, second, slower = p
    stretch = 0.0
    flowed = np.zeros(2)
    y = np.empty(x.size)
    for k in range(x.size):
        stress = x[k] * x[k] * (1.0 + soft * stretch)
        # A spring beside two springs with dashpots: the networks carry what has not flowed off yet.
        stretch = (stress + share * flowed[0] + second * flowed[1]) / (1.0 + share + second)
        flowed[0] = stretch - activated(stretch - flowed[0], scale, h / tau)
        flowed[1] = stretch - activated(stretch - flowed[1], 0.6 * scale, h / slower)
        y[k] = stretch
    return y


@compiled
def memory_wire(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Liang and Rogers' cosine transformation of a wire that is heated and pulls a spring; heat lags the power."""
    heat, convection, start_m, end_m, start_a, end_a, stress_shift, latent = p
    ambient = 22.0
    temperature, xi, before = ambient, 1.0, 1.0
    heating, begin_xi = True, 1.0
    y = np.empty(x.size)
    for k, power in enumerate(x):
        over = temperature - ambient
        # Free convection grows with the difference of temperature.
        cooling = convection * over * (0.7 + 0.3 * (abs(over) / 60.0) ** 0.25)
        last = temperature
        temperature += h * (heat * power - cooling) + latent * (before - xi)
        before = xi
        shift = stress_shift * (1.0 - xi)
        if (temperature > last) != heating:
            heating = temperature > last
            begin_xi = xi
        if heating:
            part = (temperature - start_a - shift) / (end_a - start_a)
            aim = 0.5 * begin_xi * (1.0 + math.cos(math.pi * min(max(part, 0.0), 1.0)))
            xi = min(xi, aim)
        else:
            part = (start_m + shift - temperature) / (start_m - end_m)
            aim = begin_xi + 0.5 * (1.0 - begin_xi) * (
                1.0 - math.cos(math.pi * min(max(part, 0.0), 1.0))
            )
            xi = max(xi, aim)
        y[k] = (1.0 - xi) + 0.0012 * (temperature - ambient)
    return y


@compiled
def phase_change(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A wax motor: layers of wax melt from outside and freeze late (supercooling); conduction between the layers."""
    heat, loss, conduction, latent, melting, supercooling, spread, thermal = p
    count = 8
    ambient = 20.0
    temperature = np.full(count, ambient)
    liquid = np.zeros(count)
    y = np.empty(x.size)
    for k, power in enumerate(x):
        for i in range(count):
            flow = 0.0
            if i > 0:
                flow += conduction * (temperature[i - 1] - temperature[i])
            else:
                flow += heat * power - loss * (temperature[0] - ambient)
            if i < count - 1:
                flow += conduction * (temperature[i + 1] - temperature[i])
            change = h * flow
            # Molecules of many lengths melt over a span of temperatures, and freeze that much lower.
            begins = melting + spread * liquid[i]
            ends = begins - supercooling
            reached = temperature[i] + change
            if reached > begins and liquid[i] < 1.0:
                melted = min((reached - begins) / (latent + spread), 1.0 - liquid[i])
                liquid[i] += melted
                change -= melted * latent
            elif reached < ends and liquid[i] > 0.0:
                frozen = min((ends - reached) / (latent + spread), liquid[i])
                liquid[i] -= frozen
                change += frozen * latent
            temperature[i] += change
        y[k] = (1.0 - thermal) * np.mean(liquid) + thermal * (np.mean(temperature) - ambient) / 60.0
    return y


@compiled
def solenoid(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Relays of an iron core behind eddy currents; the pull is the square of the flux, and saturates."""
    low, line, classical, excess, saturation = p
    states = demagnetised(x[0], table, low)
    # Where all relays are down there is no flux without a current.
    remanent = 0.0 if low < 0.0 else np.sum(table[:, 2])
    field = x[0]
    y = np.empty(x.size)
    flux = 0.0
    for k in range(x.size):
        field = eddied(field, x[k], h, classical, excess)
        flux = line * field + switched(states, field, table) + remanent
        linear = flux / (1.0 + saturation * abs(flux))
        y[k] = linear * (0.25 + abs(linear))
    return y


@compiled
def soft_finger(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Silicone with Mullins' softening by its largest strain, damage that heals, and Eyring's flow in fillers."""
    share, scale, tau, mullins, healing, harden, braid = p
    strain, flowed, softened = 0.0, 0.0, 0.0
    y = np.empty(x.size)
    for k in range(x.size):
        for _ in range(6):
            stiff = 1.0 - mullins * softened * math.exp(-2.0 * max(softened - strain, 0.0))
            # Fibres touch with friction when the strain is large.
            aim = (x[k] + share * flowed) / (stiff + share + harden * strain * strain)
            strain += 0.6 * (aim - strain)
        softened = max(strain, softened - h / healing * (softened - strain))
        flowed = strain - activated(strain - flowed, scale * (1.0 + braid * strain), h / tau)
        y[k] = strain
    return y


@compiled
def superelastic(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Flags: wires transform under load and back under less, so that the joint centres itself; heat lifts the load."""
    stiff, begins, ends, back, finished, stretch, warming, cooling = p
    xi = np.zeros(2)
    warm = np.zeros(2)
    y = np.empty(x.size)
    for k in range(x.size):
        total = x[k] / stiff
        for side in range(2):
            load = x[k] if side == 0 else -x[k]
            before = xi[side]
            lift = warm[side]
            # The part that transforms between two loads grows like a cosine, that which returns alike.
            up = min(max((load - begins - lift) / (ends - begins), 0.0), 1.0)
            down = min(max((load - finished - lift) / (back - finished), 0.0), 1.0)
            most = 0.5 - 0.5 * math.cos(math.pi * up)
            least = 0.5 - 0.5 * math.cos(math.pi * down)
            xi[side] = min(max(before, most), least)
            warm[side] += warming * (xi[side] - before)
            warm[side] *= math.exp(-h / cooling)
            total += (stretch if side == 0 else -stretch) * xi[side]
        y[k] = total
    return y


@compiled
def landau(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Double wells (rows: bias, width, weight) that are tilted by the field and slide over at a finite rate."""
    line, tau, coupling = p
    count = table.shape[0]
    q = np.empty(count)
    for i in range(count):
        q[i] = 1.0 if table[i, 0] < 0.0 else -1.0
    mean = 0.0
    y = np.empty(x.size)
    # It slides into its wells before anything moves.
    for k in range(-SETTLE, x.size):
        u = x[max(k, 0)]
        total = 0.0
        for i in range(count):
            tilt = (u - table[i, 0] + coupling * mean) / table[i, 1]
            q[i] += h / tau * (q[i] - q[i] ** 3 + 0.385 * tilt)
            q[i] = min(max(q[i], -3.0), 3.0)
            total += table[i, 2] * q[i]
        mean = total
        if k >= 0:
            y[k] = line * u + mean
    return y


@compiled
def ionic(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Ionic polymer: charge crosses a barrier (sinh), fills a capacity that saturates, and water flows back slowly."""
    barrier, tau, capacity, back, slow, leak, stick = p
    charge, water, bound = 0.0, 0.0, 0.0
    y = np.empty(x.size)
    for k, u in enumerate(x):
        held = charge * (1.0 + capacity * charge * charge)
        current = barrier / tau * math.sinh(min(max((u - held) / barrier, -8.0), 8.0))
        charge += h * min(max(current, -20.0), 20.0)
        # Ions bind to sites: they leave them at a smaller charge than that at which they came.
        bound += h / stick * max(charge - bound - 0.09, 0.0)
        bound -= h / stick * max(bound - charge - 0.09, 0.0)
        water += h / slow * (back * charge - water) - h * leak * water * abs(water)
        y[k] = 0.65 * charge + 0.35 * bound - water
    return y


@compiled
def pinned_walls(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Walls of domains in a rough landscape (rows: heights at places around): springs pull, viscosity drags."""
    spring, rough, viscous, cells, line = p
    walls, places = table.shape[0], table.shape[1]
    q = np.zeros(walls)
    y = np.empty(x.size)
    for k in range(-SETTLE, x.size):
        u = x[max(k, 0)]
        mean = 0.0
        for i in range(walls):
            place = (q[i] + 2.0) * cells
            whole = int(place)
            part = place - whole
            first, second = table[i, whole % places], table[i, (whole + 1) % places]
            # The force of the landscape is smooth between its places.
            mixed = part * part * (3.0 - 2.0 * part)
            pull = first + (second - first) * mixed
            q[i] += h / viscous * (spring * (u - q[i]) + rough * pull)
            q[i] = min(max(q[i], -1.9), 1.9)
            mean += q[i] / walls
        if k >= 0:
            y[k] = line * u + (1.0 - line) * mean
    return y


@compiled
def charged_mirror(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """A mirror between plates: pull of V squared over the gap squared, resonance, charge trapped in the insulator."""
    softening, trap, level, tau, frequency, damping = p
    tilt, speed, trapped = 0.0, 0.0, 0.0
    w = 2.0 * math.pi * frequency
    y = np.empty(x.size)
    for k, u in enumerate(x):
        # Trapped charge works against the voltage; a field beyond a level drives it, exponentially.
        across = u - trapped
        field = (trap * across - (1.0 - trap) * trapped) / level
        trapped += h * level / tau * math.sinh(min(max(field, -12.0), 12.0))
        pull = across * abs(across) / (1.0 - softening * min(max(tilt, -1.0), 1.5)) ** 2
        speed += h * (w * w * (pull - tilt) - 2.0 * damping * w * speed)
        tilt += h * speed
        y[k] = tilt
    return y


@compiled
def moist_wood(x: Array, h: float, p: Parameters, table: Array) -> Array:
    """Wood in damp air: water diffuses through layers the easier the damper they are; pores fill and empty late."""
    surface, diffusion, easier, line = p
    count = 6
    states = np.full((count, table.shape[0]), -1.0)
    damp = np.full(count, x[0])
    y = np.empty(x.size)
    for k, u in enumerate(x):
        flow = surface * (u - damp[0])
        for i in range(count):
            onward = 0.0
            if i < count - 1:
                ease = math.exp(easier * 0.5 * (damp[i] + damp[i + 1]))
                onward = diffusion * ease * (damp[i] - damp[i + 1])
            damp[i] += h * (flow - onward)
            flow = onward
        total = 0.0
        for i in range(count):
            total += (line * damp[i] + switched(states[i], damp[i], table)) / count
        y[k] = total
    return y
