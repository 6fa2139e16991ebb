"""Heights along a line: profile.py ARCHIVE WEST SOUTH EAST NORTH COUNT

Then the ground below a square of 1 km in the local frame of the line's first place, as a simulator has it.

  pip install heights/python && python heights/examples/profile.py vancouver.pmtiles -123.2 49.3 -122.9 49.5 100
"""

import sys

import numpy
import terrain_heights


def main() -> None:
    if len(sys.argv) != 7:
        sys.exit(__doc__)
    heights = terrain_heights.Heights(sys.argv[1], cache_bytes=64 << 20)
    west, south, east, north = map(float, sys.argv[2:6])
    count = int(sys.argv[6])
    longitudes, latitudes = numpy.linspace(west, east, count), numpy.linspace(south, north, count)
    grounds = heights.at_many(longitudes, latitudes)
    words = {terrain_heights.VOID: "void", terrain_heights.OUTSIDE: "outside"}
    print(f"metres above {heights.above}")
    for place in range(count):
        at = f"{longitudes[place]:.9f} {latitudes[place]:.9f}"
        if grounds.status[place] in (terrain_heights.MEASURED, terrain_heights.FILLED):
            normal = " ".join(f"{part:.6f}" for part in grounds.normal[place])
            print(f"{at} {grounds.height[place]:.4f} {grounds.error[place]:.4f} {normal}")
        else:
            print(at, words[grounds.status[place]])
    frame = terrain_heights.Frame(west, south)
    easts, norths = [side.ravel() for side in numpy.meshgrid(numpy.linspace(0, 1000, 5), numpy.linspace(0, 1000, 5))]
    ups = heights.in_frame_many(frame, easts, norths)
    print("metres east, north and up of the first place")
    for place in numpy.flatnonzero(ups.status == terrain_heights.MEASURED):
        print(f"{easts[place]:.0f} {norths[place]:.0f} {ups.height[place]:.4f} {ups.error[place]:.4f}")


if __name__ == "__main__":
    main()
