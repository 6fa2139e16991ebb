// GeographicLib for Rust: plain functions, and no exception leaves them. Each returns 0, or 1 where GeographicLib threw.

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/Geoid.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/TransverseMercatorExact.hpp>
#include <GeographicLib/UTMUPS.hpp>

#include <vector>

using namespace GeographicLib;

namespace {
template <typename Work> int guarded(Work work) {
    try {
        work();
        return 0;
    } catch (...) {
        return 1;
    }
}
}

extern "C" {

// zone 0 is the polar one.
int shim_to_utm(int zone, double latitude, double longitude, int *north, double projected[2]) {
    return guarded([&] {
        int found;
        bool is_north;
        UTMUPS::Forward(latitude, longitude, found, is_north, projected[0], projected[1], zone);
        *north = is_north;
    });
}

// Scale 1 on the central meridian, no false easting.
int shim_from_transverse_mercator(double meridian, double x, double y, double geodetic[2]) {
    return guarded([&] {
        const TransverseMercatorExact exact(Constants::WGS84_a(), Constants::WGS84_f(), 1);
        exact.Reverse(meridian, x, y, geodetic[0], geodetic[1]);
    });
}

// local: east, north, up of a point from an origin; both are latitude, longitude, height.
int shim_to_local(const double origin[3], const double point[3], double local[3]) {
    return guarded([&] {
        const LocalCartesian frame(origin[0], origin[1], origin[2]);
        frame.Forward(point[0], point[1], point[2], local[0], local[1], local[2]);
    });
}

// Heights of a geoid at places (latitude, longitude), bilinear in the grid FOLDER/NAME.pgm.
int shim_undulations(const char *folder, const char *name, int count, const double *places, double *metres) {
    return guarded([&] {
        const Geoid geoid(name, folder, false);
        for (int i = 0; i < count; ++i) metres[i] = geoid(places[2 * i], places[2 * i + 1]);
    });
}

// position: x, y, z; rotation: rows of the matrix from east, north, up to x, y, z.
int shim_to_earth_centred(double latitude, double longitude, double height, double position[3], double rotation[9]) {
    return guarded([&] {
        std::vector<double> matrix(9);
        Geocentric::WGS84().Forward(latitude, longitude, height, position[0], position[1], position[2], matrix);
        for (int i = 0; i < 9; ++i) rotation[i] = matrix[i];
    });
}

int shim_to_geodetic(double x, double y, double z, double geodetic[3]) {
    return guarded([&] { Geocentric::WGS84().Reverse(x, y, z, geodetic[0], geodetic[1], geodetic[2]); });
}

int shim_distance(double latitude1, double longitude1, double latitude2, double longitude2, double *metres) {
    return guarded([&] { Geodesic::WGS84().Inverse(latitude1, longitude1, latitude2, longitude2, *metres); });
}

int shim_from_utm(int zone, int north, double easting, double northing, double geodetic[2]) {
    return guarded([&] { UTMUPS::Reverse(zone, north != 0, easting, northing, geodetic[0], geodetic[1]); });
}
}
