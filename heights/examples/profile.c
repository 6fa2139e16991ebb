/* Heights along a line: profile ARCHIVE WEST SOUTH EAST NORTH COUNT
 *
 *   cc -I heights/include heights/examples/profile.c -L target/release -lterrain_heights -lm -o profile
 */
#include <stdio.h>
#include <stdlib.h>

#include "terrain_heights.h"

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
    printf("metres above %s\n", terrain_heights_above(heights));
    for (int place = 0; place < places; ++place) {
        double part = places > 1 ? (double)place / (places - 1) : 0.0;
        double longitude = west + part * (east - west), latitude = south + part * (north - south);
        TerrainGround ground;
        switch (terrain_heights_at(heights, longitude, latitude, 255, &ground)) {
        case TERRAIN_STATUS_MEASURED:
        case TERRAIN_STATUS_FILLED: /* its error is not a number */
            printf("%.9f %.9f %.4f %.4f %.6f %.6f %.6f\n", longitude, latitude, ground.height, ground.error,
                   ground.normal[0], ground.normal[1], ground.normal[2]);
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
