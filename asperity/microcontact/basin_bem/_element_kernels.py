"""Summits pressed alone by small boundary-element problems on the pixels of their basins."""

from __future__ import annotations

import math

import numpy as np

from surfaces.numerics.compiled import compiled, inner
from surfaces.numerics.splines import expand

from ._closing_kernels import MOST_ELEMENTS, MOST_SIDE_ELEMENTS, OUTSIDE, contact_size, solve

ASPECTS = np.array([1.0, 1.5, 2.25, 3.4, 5.0])
"""Ratios of the sides of the elements."""

HALF_WINDOW = 96
"""Half the side [pixels] of the window about a summit that must hold its basin above the flat."""

GRID_FITS = 4
"""Most fits of the grid to the part of the basin above the flat."""

TIGHT_FIT = 0.75
"""A fitted grid is kept if its size is more than this part of that of the fit before."""

LEAST_OVERLAP = 0.4
"""Least number of elements that overlap with the flat, over the number wanted: else they shrink."""

FEW_PIXELS = 12
"""Up to this number of pixels above the flat the grid has the axes of the summit, not of them."""

FIRST_BOX = 1.7
"""Half a side of the first box about a summit, over sqrt(approach / curvature)."""

GRID_TRIES = 6
"""Most grids tried for one contact under a force."""

VIEWED_DEPTH = 1.1
"""Depth below the summit down to which elements are made, over the expected approach."""

SHORT_DEPTH = 0.35
"""Part of this depth by which the flat may stay above it; beyond, elements are too large."""

LEAST_DEPTH_RATIO = 1e-4
"""Least depth of the next try over the last one; single precision resolves no smaller part."""


@inner()
def _wrapped(place, count):
    """Index `place` modulo `count`; most are in range, and need no division."""
    return place if 0 <= place < count else place % count


@inner()
def _flood(
    heights, labels, owner, periodic, tilt, peak, row, col, place, level, mark, stamp, rows, cols
):  # fmt: skip
    """Pixels of a basin above `level` that are connected to the pixel (row, col) (flood fill).

    The surface falls by `tilt` [m] per pixel along y and x from `place` on. Returns the number of
    pixels; 0 if they leave the window or reach points of no basin. The flood stops at the border of
    a map that is not periodic.
    """
    ny, nx = heights.shape
    rows[0], cols[0] = row, col
    mark[HALF_WINDOW, HALF_WINDOW] = stamp
    count, done = 1, 0
    while done < count:
        y, x = rows[done], cols[done]
        done += 1
        for step in range(9):
            r, c = y + step // 3 - 1, x + step % 3 - 1
            dr, dc = r - row, c - col
            if abs(dr) > HALF_WINDOW or abs(dc) > HALF_WINDOW:
                return 0
            if mark[HALF_WINDOW + dr, HALF_WINDOW + dc] == stamp:
                continue
            if periodic:
                r, c = _wrapped(r, ny), _wrapped(c, nx)
            elif r < 0 or c < 0 or r >= ny or c >= nx:
                continue
            fall = tilt[0] * (row + dr - place[0]) + tilt[1] * (col + dc - place[1])
            if heights[r, c] - fall < level:
                continue
            own = labels[r, c]
            if own < 0:
                return 0
            if owner[own] != peak:
                continue
            mark[HALF_WINDOW + dr, HALF_WINDOW + dc] = stamp
            rows[count], cols[count] = row + dr, col + dc
            count += 1
    return count


@inner()
def _turn(heights, tilt, place, rows, cols, count, level, spacing):
    """Direction [rad] of the long axis of the pixels above `level`, weighted by their height."""
    ny, nx = heights.shape
    w = my = mx = yy = xx = yx = 0.0
    for k in range(count):
        fall = tilt[0] * (rows[k] - place[0]) + tilt[1] * (cols[k] - place[1])
        up = max(heights[_wrapped(rows[k], ny), _wrapped(cols[k], nx)] - fall - level, 0.0)
        y, x = (rows[k] - rows[0]) * spacing[0], (cols[k] - cols[0]) * spacing[1]
        w += up
        my += up * y
        mx += up * x
        yy += up * y * y
        xx += up * x * x
        yx += up * y * x
    my, mx = my / w, mx / w
    return 0.5 * math.atan2(2.0 * (yx / w - my * mx), (xx / w - mx * mx) - (yy / w - my * my))


@inner()
def _sample(
    heights, labels, owner, periodic, flat, width, tilt, peak, place, top, depth, below, spacing,
    turn, box, points, penetration, inside, stack,
):  # fmt: skip
    """Grid of about `points` elements over the box (u0, u1, v0, v1) [m], turned about the summit.

    Fills `penetration` [m] and `inside` (elements connected to the highest one, down to `below` [m]
    under the flat), and tightens the box to the elements that overlap with the flat. Returns the
    shape, the sides, the row of `ASPECTS`, the first corner, and the number that overlap.
    """
    ny, nx = heights.shape
    along, across = box[1] - box[0], box[3] - box[2]
    kind = np.argmin(np.abs(np.log(ASPECTS) - 0.6 * math.log(max(along / across, 1.0))))
    side = math.sqrt(along * across / points)
    hu, hv = side * math.sqrt(ASPECTS[kind]), side / math.sqrt(ASPECTS[kind])
    nu = min(max(math.ceil(along / hu), 4), MOST_SIDE_ELEMENTS)
    nv = min(max(math.ceil(across / hv), 4), MOST_SIDE_ELEMENTS)
    stretch = max(along / (nu * hu), across / (nv * hv), 1.0)
    hu, hv = hu * stretch, hv * stretch
    u0 = 0.5 * (box[0] + box[1]) - 0.5 * (nu - 1) * hu
    v0 = 0.5 * (box[2] + box[3]) - 0.5 * (nv - 1) * hv
    c, s = math.cos(turn), math.sin(turn)
    best, nearest, first = 0.0, np.inf, -1
    for i in range(nv):
        for j in range(nu):
            u, v = u0 + j * hu, v0 + i * hv
            y, x = place[0] + (s * u + c * v) / spacing[0], place[1] + (c * u - s * v) / spacing[1]
            k = i * nu + j
            penetration[k], inside[k] = -np.inf, 0
            row, col = math.floor(y + 0.5), math.floor(x + 0.5)
            fall = tilt[0] * (y - place[0]) + tilt[1] * (x - place[1])
            if periodic:
                y, x = y - ny * math.floor(y / ny), x - nx * math.floor(x / nx)
                row, col = _wrapped(row, ny), _wrapped(col, nx)
            elif row < 0 or col < 0 or row >= ny or col >= nx:
                continue
            own = labels[row, col]
            if own >= 0 and owner[own] == peak:
                penetration[k] = depth - max(top - (expand(flat, width, y, x)[0] - fall), 0.0)
                away = u * u + v * v  # all of a flat top are alike
                if penetration[k] > best or (penetration[k] == best and away < nearest):
                    best, nearest, first = penetration[k], away, k
    if first < 0:
        return 0, 0, 0.0, 0.0, 0, u0, v0, 0
    stack[0], count, done, over = first, 1, 0, 0
    inside[first] = 1
    low_u = high_u = first % nu
    low_v = high_v = first // nu
    while done < count:
        k = stack[done]
        done += 1
        i, j = k // nu, k % nu
        if penetration[k] > 0.0:
            over += 1
            low_u, high_u = min(low_u, j), max(high_u, j)
            low_v, high_v = min(low_v, i), max(high_v, i)
        for step in range(9):
            a, b = i + step // 3 - 1, j + step % 3 - 1
            if 0 <= a < nv and 0 <= b < nu:
                k = a * nu + b
                if not inside[k] and penetration[k] > -below:
                    inside[k], stack[count] = 1, k
                    count += 1
    box[0], box[1] = u0 + (low_u - 0.7) * hu, u0 + (high_u + 0.7) * hu
    box[2], box[3] = v0 + (low_v - 0.7) * hv, v0 + (high_v + 0.7) * hv
    return nv, nu, hv, hu, kind, u0, v0, over


@inner()
def _elements(peak, depth, surface, summits, points, stamp, space):
    """Elements about a peak that overlap with a flat at `depth` [m] below its top.

    Arguments are those of `press_levels`; `stamp` differs for each call with one `space`. Fills
    rows, columns, overlaps over the depth and indices of the elements in `space`. Returns the
    number of elements, -1 if the basin reaches too far, the grid of `_sample`, and the cosine and
    sine of its turn.
    """
    heights, labels, owner, periodic, flat, width, spacing = surface
    peak_row, peak_col, places, tops, axes, curvature, floors, tilts = summits
    (mark, pixel_rows, pixel_cols), (penetration, inside, stack, number, box), scratch = space
    overlap, row, col = scratch[2], scratch[4], scratch[5]
    (ny, nx), rim = heights.shape, max(spacing[0], spacing[1])
    top, tilt = tops[peak], tilts[peak]
    place = places[peak]  # on the side of the seam where its pixel is
    below = max(top - depth - floors[peak], 0.0)
    low = top - depth - below
    wanted = 2.0 * points if floors[peak] < np.inf else points
    count = _flood(
        heights, labels, owner, periodic, tilt, peak, peak_row[peak], peak_col[peak], place,
        low, mark, stamp, pixel_rows, pixel_cols,
    )  # fmt: skip
    if count == 0:
        return -1, 0, 0, 0.0, 0.0, 0, 0.0, 0.0, 1.0, 0.0
    turn = axes[peak]
    if count > FEW_PIXELS:
        turn = _turn(heights, tilt, place, pixel_rows, pixel_cols, count, low, spacing)
    c, s = math.cos(turn), math.sin(turn)
    box[0], box[1], box[2], box[3] = -rim, rim, -rim, rim
    for k in range(count):
        y, x = pixel_rows[k] - place[0], pixel_cols[k] - place[1]
        high = heights[_wrapped(pixel_rows[k], ny), _wrapped(pixel_cols[k], nx)]
        if high - (tilt[0] * y + tilt[1] * x) < top - depth:
            continue
        y, x = y * spacing[0], x * spacing[1]
        u, v = c * x + s * y, c * y - s * x
        box[0], box[1] = min(box[0], u - rim), max(box[1], u + rim)
        box[2], box[3] = min(box[2], v - rim), max(box[3], v + rim)
    if count <= FEW_PIXELS:
        for k in range(4):
            tip = FIRST_BOX * math.sqrt(depth / curvature[peak, 1 - k // 2])
            box[k] = min(max(box[k], -tip), tip)
    enough = LEAST_OVERLAP * wanted
    for _ in range(GRID_FITS):
        size = (box[1] - box[0]) * (box[3] - box[2])
        nv, nu, hv, hu, kind, u0, v0, over = _sample(
            heights, labels, owner, periodic, flat, width, tilt, peak, place, top, depth,
            below, spacing, turn, box, wanted, penetration, inside, stack,
        )  # fmt: skip
        tighter = (box[1] - box[0]) * (box[3] - box[2]) / size
        finer = enough * tighter / max(over, 1)
        if over < MOST_ELEMENTS:  # else more hang together than larger elements showed
            finer = min(max(finer, 1.0), MOST_SIDE_ELEMENTS**2 / wanted)
            if tighter > TIGHT_FIT and finer * TIGHT_FIT < 1.0:
                break
        wanted *= finer
    total = np.int64(0)
    number[: nv * nu] = OUTSIDE
    for k in range(nv * nu):
        if inside[k] and penetration[k] > 0.0 and total < MOST_ELEMENTS:
            row[total], col[total], overlap[total] = k // nu, k % nu, penetration[k] / depth
            number[k] = total
            total += 1
    if total == MOST_ELEMENTS:
        total = np.int64(-1)
    return total, nv, nu, hv, hu, kind, u0, v0, c, s


@compiled()
def press_levels(
    slot, first, last, peak, surface, summits, depths, unit, m, kernels, points, tolerance, out,
    space,
):  # fmt: skip
    """Press a peak at the levels `first` to `last` - 1 of row `slot` of `depths`.

    Fills `out` (n, levels, 8) [SI]: force, area, centre y, x and moments yy, xx, yx of the
    pressure, area of the peak above the flat. All are zero where too few elements overlap; the
    force is negative, and the row ends, where the basin reaches too far. `surface` holds heights,
    labels, owners of labels, periodicity, spline, its width and the spacing; `summits` pixels,
    places [pixels], heights [m], axes [rad], curvatures [1/m], floors [m] (finite for joined
    summits, which get twice the elements) and tilts [m per pixel]; `depths` ascending approaches
    [m], (n, levels), then zeros; `unit` the compliance of an element of unit area.
    """
    (number, scratch), mark = (space[1][3], space[2]), space[0][0]
    system, closed, overlap, work, row, col = scratch
    edge = math.gamma(0.5 * (3.0 + m)) / math.gamma(0.5 * (5.0 - m))
    mark[:] = 0
    for level in range(first, last):
        depth = depths[slot, level]
        if not depth > 0.0:
            break
        total, nv, nu, hv, hu, kind, u0, v0, c, s = _elements(
            peak, depth, surface, summits, points, level - first + 1, space
        )
        if total < 0:
            out[slot, level, 0] = -1.0
            break
        if total < 4:
            continue
        solve(
            total, row, col, overlap, kernels[kind], np.float32(0.0), np.float32(np.inf), tolerance,
            system, closed, work,
        )  # fmt: skip
        force, y, x = 0.0, 0.0, 0.0
        for k in range(total):
            u, v = u0 + col[k] * hu, v0 + row[k] * hv
            force += closed[k]
            y += closed[k] * (s * u + c * v)
            x += closed[k] * (c * u - s * v)
        element = hu * hv
        out[slot, level, 0] = force * depth * element ** (0.5 * (1.0 + m)) / unit
        out[slot, level, 1] = element * contact_size(
            number, nv, nu, math.sqrt(hv / hu), math.sqrt(hu / hv), closed, work[0], m, edge, np.inf
        )
        out[slot, level, 7] = total * element
        y, x = y / force, x / force
        out[slot, level, 2], out[slot, level, 3] = y, x
        for k in range(total):
            u, v = u0 + col[k] * hu, v0 + row[k] * hv
            dy, dx, part = s * u + c * v - y, c * u - s * v - x, closed[k] / force
            out[slot, level, 4] += part * dy * dy
            out[slot, level, 5] += part * dx * dx
            out[slot, level, 6] += part * dy * dx


@compiled()
def areas_under_load(
    first, last, peaks, forces, depths, surface, summits, unit, m, hardness, kernels, points,
    tolerance, out, space,
):  # fmt: skip
    """Fill `out` from `first` to `last` - 1 with contact areas [m^2] under forces and a hardness.

    `depths` are estimates of the approaches [m], `hardness` is in Pa; other arguments are those of
    `press_levels`. An area is zero where the basin reaches too far or does not bear the force.
    """
    number, scratch, mark = space[1][3], space[2], space[0][0]
    system, closed, overlap, work, row, col = scratch
    edge = math.gamma(0.5 * (3.0 + m)) / math.gamma(0.5 * (5.0 - m))
    mark[:], stamp = 0, 0
    for slot in range(first, last):
        out[slot] = 0.0
        force, depth = forces[slot], VIEWED_DEPTH * depths[slot]
        for attempt in range(GRID_TRIES):
            stamp += 1
            total, nv, nu, hv, hu, kind, _, _, _, _ = _elements(
                peaks[slot], depth, surface, summits, points, stamp, space
            )
            if total < 0:
                break
            side = hu * hv
            load = force * unit / (depth * side ** (0.5 * (1.0 + m)))
            bound = np.float32(hardness * unit / (depth * side ** (0.5 * (m - 1.0))))
            if total < 4 or load > 0.99 * total * bound:
                depth *= 1.5
                continue
            level = solve(
                total, row, col, overlap, kernels[kind], np.float32(load), bound, tolerance,
                system, closed, work,
            )  # fmt: skip
            if level < 0.0 or (level > SHORT_DEPTH and attempt < GRID_TRIES - 1):
                depth *= VIEWED_DEPTH * max(1.0 - level, LEAST_DEPTH_RATIO)
                continue
            sides, left = (math.sqrt(hv / hu), math.sqrt(hu / hv)), work[0]
            size = contact_size(number, nv, nu, *sides, closed, left, m, edge, bound)
            out[slot] = max(side * size, force / hardness)
            break
