/* The C interface of the tracer. Lengths in mm; arrays are contiguous float64 unless said otherwise.
   Functions return GLASS_OK, GLASS_CANCELLED or GLASS_FAILED; nothing throws across this line. */
#ifndef GLASSWORKBENCH_TRACER_H
#define GLASSWORKBENCH_TRACER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GLASS_INTERFACE_VERSION 5
#define GLASS_OK 0
#define GLASS_CANCELLED 1
#define GLASS_FAILED 2

typedef struct glass_scene glass_scene;

typedef struct {
    double cutoff;         /* weights below it are left out, into the bound */
    int32_t maximum_depth; /* interfaces along a path, at most 1000 */
    int32_t absorption;    /* 0: the effect is not compiled into the loop at all */
} glass_settings;

typedef struct {
    int32_t parallel; /* 0 pinhole, 1 telecentric */
    int32_t width, height;
    double origin[3], right[3], up[3], forward[3];
    double half_height; /* of the image: mm if parallel, else at distance 1 */
} glass_camera;

/* Shared with the caller while a call runs: it may set `cancel` and read `done` at any time. */
typedef struct {
    int32_t cancel;
    int32_t reserved;
    int64_t done;
} glass_control;

int32_t glass_interface_version(void);
/* Width of the vector instructions this processor has: 2 (baseline), 4 (x86-64-v3) or 8 (x86-64-v4) doubles. */
int32_t glass_vector_width(void);

glass_scene* glass_scene_new(void);
void glass_scene_free(glass_scene* scene);
int32_t glass_add_revolved(glass_scene* scene, const double* meridian /* n x 4 x 3 */, int64_t n, const double* base,
                           const double* axis);
int32_t glass_add_mesh(glass_scene* scene, const double* vertices, const double* normals, int64_t vertex_count,
                       const int32_t* triangles, int64_t triangle_count);
/* Sheets: shapes (sheets x 4, int32) degree in u and in v, patches in u and in v; then one after the other, of all
   sheets, the knots (u before v) and the homogeneous control points. Triangles: the tables of curved_triangles.py. */
int32_t glass_add_patches(glass_scene* scene, const int32_t* shapes, int64_t sheet_count, const double* knots,
                          const double* control_points, int64_t triangle_count, const int32_t* sheet_of_triangle,
                          const double* corners /* m x 3 x 3 */, const double* uv /* m x 3 x 2 */, const int32_t* pole,
                          int64_t edge_count, const double* edges /* e x 9 x 3 */, const int32_t* edge /* m x 3 */,
                          const int32_t* along /* m x 3 */, const double* low /* m x 3 */,
                          const double* high /* m x 3 */, const double* cone_axis /* m x 3 */,
                          const double* cone_sine /* m */);
int32_t glass_add_ellipsoid(glass_scene* scene, const double* centre, const double* semi_axes,
                            const double* rotation /* 3 x 3, columns are the axes */);
/* One body of n ellipsoids, at least one, that do not touch. */
int32_t glass_add_ellipsoids(glass_scene* scene, int64_t n, const double* centres, const double* semi_axes,
                             const double* rotations /* n x 3 x 3 */);
int32_t glass_set_media(glass_scene* scene, const int32_t* medium_of_bits, int64_t combinations,
                        const double* refractive_indices, const double* absorptions /* media x 3 */, int64_t media);
int32_t glass_add_panel(glass_scene* scene, const double* origin, const double* u, const double* v,
                        const double* radiance);
int32_t glass_set_environment(glass_scene* scene, const double* pixels /* h x w x 3 */, int64_t height, int64_t width);
int32_t glass_finish(glass_scene* scene, double brightest);

/* Any rays: radiance (n x 3), left_out (n x 3), bound (n), depth_mm (n), crossings (n, int64), leaks (n, int64). */
int32_t glass_radiance(const glass_scene* scene, const glass_settings* settings, int32_t threads,
                       glass_control* control, int64_t n, const double* origins, const double* directions,
                       double* radiance, double* left_out, double* bound, double* depth, int64_t* crossings,
                       int64_t* leaks);

/* Mean radiance over the wanted pixels (uint8 a pixel) in the listed tiles of 32 x 32 pixels, to a tolerance;
   each pixel is halved at least `halvings` times. ambient (3) stands for the light at the end of paths that were left
   out. Written: radiance (pixels x 3), the estimated sampling error, the bound on the error of what was left out, depth
   (pixels each). totals (3): rays, crossings, leaks, added to. */
int32_t glass_image(const glass_scene* scene, const glass_settings* settings, const glass_camera* camera,
                    double tolerance, int32_t halvings, const double* ambient, int32_t threads, glass_control* control,
                    int64_t n, const int64_t* tiles, const uint8_t* wanted, float* radiance, float* sampling,
                    float* pruned, float* depth, int64_t* totals);

/* The refracted path of one ray, at most `room` interfaces; returns their number, or -1 if it failed.
   numbers (room x 4, int32): body, entering, medium before, medium after; values (room x 5): point, cosine,
   reflectance. */
int64_t glass_follow(const glass_scene* scene, const double* origin, const double* direction, int64_t room,
                     int32_t* numbers, double* values);

#ifdef __cplusplus
}
#endif
#endif
