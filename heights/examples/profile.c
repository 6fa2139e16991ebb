/* Heights along a line: profile ARCHIVE WEST SOUTH EAST NORTH COUNT
 *
 * Of each place: longitude, latitude, height, error, normal; then metres east and north in the local frame of the first place, which is
 * flat in space, as simulators have it, and metres up, where the frame's vertical meets the ground, with the error along that.
 *
 *   cc -I heights/include heights/examples/profile.c -L target/release -lterrain_heights -lm -o profile
 */
#include <stdio.h>
#include <stdlib.h>

#include "terrain_heights.h"

/* The ground in the frame, at the plan position of a point of the ground. */
static void print_in_frame(const TerrainHeights *heights, const TerrainFrame *frame, double longitude, double latitude,
                           double height) {
    TerrainFrame there;
    TerrainGround ground;
    double east = 0.0, north = 0.0;
    terrain_frame(longitude, latitude, height, &there);
    for (int axis = 0; axis < 3; ++axis) {
        east += (there.origin[axis] - frame->origin[axis]) * frame->east[axis];
        north += (there.origin[axis] - frame->origin[axis]) * frame->north[axis];
    }
    TerrainStatus status = terrain_heights_in_frame(heights, frame, east, north, 255, &ground);
    if (status == TERRAIN_STATUS_MEASURED || status == TERRAIN_STATUS_FILLED) {
        printf(" %.4f %.4f %.4f %.4f\n", east, north, ground.height, ground.error);
    } else {
        printf("\n");
    }
}

int main(int count, char **arguments) {
    if (count != 7) {
        fprintf(stderr, "profile ARCHIVE WEST SOUTH EAST NORTH COUNT\n");
        return 2;
    }
    char reason[256];
    TerrainHeights *heights = terrain_heights_open(arguments[1], 64 << 20, reason, sizeof reason);
    if (heights == NULL) {
        fprintf(stderr, "%s\n", reason);
        return 1;
    }
    double west = atof(arguments[2]), south = atof(arguments[3]);
    double east = atof(arguments[4]), north = atof(arguments[5]);
    int places = atoi(arguments[6]);
    TerrainFrame frame;
    if (!terrain_frame(west, south, 0.0, &frame)) {
        fprintf(stderr, "there is no such place\n");
        return 2;
    }
    printf("metres above %s\n", terrain_heights_above(heights));
    for (int place = 0; place < places; ++place) {
        double part = places > 1 ? (double)place / (places - 1) : 0.0;
        double longitude = west + part * (east - west), latitude = south + part * (north - south);
        TerrainGround ground;
        switch (terrain_heights_at(heights, longitude, latitude, 255, &ground)) {
        case TERRAIN_STATUS_MEASURED:
        case TERRAIN_STATUS_FILLED: /* its error is not a number */
            printf("%.9f %.9f %.4f %.4f %.6f %.6f %.6f", longitude, latitude, ground.height, ground.error,
                   ground.normal[0], ground.normal[1], ground.normal[2]);
            print_in_frame(heights, &frame, longitude, latitude, ground.height);
            break;
        case TERRAIN_STATUS_VOID:
            printf("%.9f %.9f void\n", longitude, latitude);
            break;
        case TERRAIN_STATUS_OUTSIDE:
            printf("%.9f %.9f outside\n", longitude, latitude);
            break;
        case TERRAIN_STATUS_FAILED:
            fprintf(stderr, "%s cannot be read there\n", arguments[1]);
            return 1;
        }
    }
    terrain_heights_close(heights);
    return 0;
}
