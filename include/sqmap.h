// sqmap from C: bake closed triangle meshes into models, query them for contact and signed distance, compute forces.
//
// Shapes: points are rows of three doubles, x y z, one behind the other; a rotation is nine doubles, row by row.
// Units: lengths are the mesh's own, or metres after sqmap_bake_options.unit; angles radians; sessions are in SI units.
// Frames: the mesh's own where no pose is given, else the frame in which poses are given.
// Structs: set `size` to sizeof the struct and everything else to zero; zero stands for the default. A program that was
// compiled against another 0.x of this header goes on working: what it does not know stays at its default.
// Libraries: libsqmap has all of it. libsqmap_query, a third as large, leaves out sqmap_bake, sqmap_bake_file,
// sqmap_option_range, sqmap_export and paper models, which it refuses with SQMAP_E_MISSING.
// Errors: every function that can fail returns a code; sqmap_last_error() has the reason of this thread's last one. No
// exception leaves the library. A handle that is {0}, closed or of another kind is an error (SQMAP_E_HANDLE), never a crash;
// pointers have to be right. Errors count from zero, as arrays do: "mesh.triangles[3]" and "points.xyz[3]" are fourth rows.
// Threads: any number may query one model or probe at once, each into arrays of its own. A workspace and a session belong to one
// thread at a time. Close a handle when no call is using it; what was made of it lives on.
#pragma once

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(SQMAP_BUILDS_LIBRARY)
#define SQMAP_API __declspec(dllexport)
#elif defined(_WIN32)
#define SQMAP_API __declspec(dllimport)
#else
#define SQMAP_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

// ---------------------------------------------------------------------------------------------------- errors

/// A function returns one of these.
typedef enum sqmap_code {
    SQMAP_OK = 0,
    SQMAP_E_ARGUMENT = 1,   ///< a pointer, size or number that is not taken
    SQMAP_E_HANDLE = 2,     ///< {0}, closed, never opened, or of another kind
    SQMAP_E_FILE = 3,       ///< cannot be read or written
    SQMAP_E_MODEL = 4,      ///< no model, one that is cut short, or damaged
    SQMAP_E_VERSION = 5,    ///< a model of another format version
    SQMAP_E_MESH = 6,       ///< a mesh that is refused; sqmap_error.name says why: "E_OPEN"
    SQMAP_E_CANCELLED = 7,  ///< by the progress callback
    SQMAP_E_MISSING = 8,    ///< the model was baked without what the call needs
    SQMAP_E_MEMORY = 9,
    SQMAP_E_INTERNAL = 10  ///< an error of the library itself
} sqmap_code;

/// Why a call failed. Texts are never null.
typedef struct sqmap_error {
    size_t size;
    int32_t code;         ///< sqmap_code
    const char* name;     ///< the code as text: "E_ARGUMENT"; of a refused mesh: "E_OPEN"
    const char* element;  ///< where: "options.band", "mesh.triangles[11]", a file's name; in a mesh file "face 12", from 1
    const char* message;  ///< what was found
    const char* cure;     ///< what helps
} sqmap_error;

/// The error of this thread's last call that failed; valid until the next one that fails. Never null.
SQMAP_API const sqmap_error* sqmap_last_error(void);
/// Its cure, in which settings and functions are named as one of sqmap_words writes them; for another number as C does. Valid as
/// long as the error. Never null.
SQMAP_API const char* sqmap_last_cure(int32_t words);
/// "0.2.0". Any thread.
SQMAP_API const char* sqmap_version(void);
/// Format version of the models that are read and written. Any thread.
SQMAP_API uint32_t sqmap_format_version(void);

/// A text for the caller: up to `capacity` bytes are written to `text`, a final zero included; `needed` is what the whole takes.
/// text may be null with capacity 0, to learn `needed`.
typedef struct sqmap_text {
    size_t size;
    char* text;
    size_t capacity;
    size_t needed;
    int32_t words;  ///< of sqmap_notes alone: sqmap_words; 0: as the bake that made the model said, C where it was opened
} sqmap_text;

// ---------------------------------------------------------------------------------------------------- models

/// A baked model in memory. {0} is none.
typedef struct sqmap_model {
    uint64_t id;
} sqmap_model;

/// Triangles: nothing is promised about them.
typedef struct sqmap_mesh {
    size_t size;
    const double* vertices;  ///< vertex_count x 3
    size_t vertex_count;
    const int64_t* triangles;  ///< triangle_count x 3, zero-based
    size_t triangle_count;
} sqmap_mesh;

/// The highest rung of the ladder of cures for meshes that bound no solid.
typedef enum sqmap_repair {
    SQMAP_REPAIR_DEFAULT = 0,  ///< as SQMAP_REPAIR_WRAP
    SQMAP_REPAIR_NONE = 1,
    SQMAP_REPAIR_SAFE = 2,   ///< what leaves no doubt about the surface
    SQMAP_REPAIR_CLOSE = 3,  ///< fill holes, stitch cracks
    SQMAP_REPAIR_WRAP = 4    ///< a new surface around what is enclosed
} sqmap_repair;

/// The solid that is meant.
typedef enum sqmap_solid {
    SQMAP_SOLID_AS_IS = 0,  ///< what the surface bounds
    SQMAP_SOLID_OUTER = 1   ///< what cannot be reached from outside, proven to hold every triangle
} sqmap_solid;

/// Called with a stage's name and how much of it is done, 0 to 1, on the thread that bakes. Not zero: stop.
typedef int32_t (*sqmap_progress)(void* context, const char* stage, double done);

/// The language whose names of settings and functions stand in notes and cures; programs in C leave it at zero.
enum sqmap_words { SQMAP_WORDS_C = 0, SQMAP_WORDS_PYTHON = 1, SQMAP_WORDS_JAVASCRIPT = 2 };

/// Thresholds of the paper that sqmap bake has as options, of the same names and defaults; lengths of section 3 are in roots of
/// the surface area, areas shares of it. Zero: the default; below zero: 0, where that is in range and not the default.
/// sqmap_option_range gives ranges, docs/paper-claims.md effects.
typedef struct sqmap_paper_options {
    size_t size;
    // Sections 2 and 3: models of either projection.
    int32_t without_taper, without_bend;
    int32_t cuts;             ///< 0 passes, 1 printed, with thresholds of its own
    int32_t exact_geodesics;  ///< not zero: eq. 4 over every triangle
    uint32_t protrusion_sources;
    double salient_window, salient_prominence, locale_width, boundary_strength, protrusion_ratio;
    double curvature_window, hyperbolic_curvature;
    double boundary_concavity, curvature_floor, hyperbolic_share, minimum_part, fragment_roundness;
    int32_t mean_curvature;                      ///< of printed cuts: 0 area, 1 count
    double printed_strength, printed_curvature;  ///< of printed cuts
    double max_looseness, max_q2;
    // Section 4.1: paper models (projection 1).
    uint32_t rows, columns;  ///< of layer 2; 0: by the target error
    int32_t subdivisions;    ///< A_S
    double offset_constant;  ///< a_N
    int32_t offset_radius;
    int32_t smoothing;         ///< of the smoothed map: 0 the surface, 1 distances, as section 6 has it
    double smoothing_length;   ///< of the surface, share of R_max
    int32_t smoothing_radius;  ///< of distances, samples; below zero: no smoothed map of either
    int32_t smoothing_kernel;  ///< of distances: 0 binomial, 1 box, 2 Gaussian
} sqmap_paper_options;

/// How to bake. Zero: the default of sqmap bake; below zero: 0, where that is in range and not the default. sqmap_option_range
/// gives ranges.
typedef struct sqmap_bake_options {
    size_t size;
    double target_error;      ///< percent of R_max, depth error of layer 3 at the 99th percentile; default 0.5
    double band;              ///< percent of R_max within which signed distances are exact; default 5
    double thickness;         ///< above 0: open meshes become plates this thick, mesh units
    uint32_t max_parts;       ///< default 24
    int32_t projection;       ///< 0 central, 1 the paper's normal projection
    int32_t repair;           ///< sqmap_repair
    int32_t accepts_surface;  ///< not zero: an open mesh is taken as a surface without inside
    int32_t without_exact;    ///< not zero: leave out the exact layer, and with it the triangles
    uint32_t threads;         ///< 0: one a core; the bytes do not depend on it
    sqmap_progress progress;  ///< may be null
    void* progress_context;   ///< may be null
    const char* source;       ///< what sqmap_info names as the model's source; may be null
    int32_t words;            ///< sqmap_words: how notes and cures write these members
    int32_t without_input;    ///< not zero: leave out the mesh's own coordinates and numbers: exact distances are in float then
    double unit;              ///< metres per unit of the mesh, 0.001 of millimetres: the model is in metres; 0: in the mesh's own
    double gap;               ///< share of R_max: narrower gaps of an outer solid are closed; default 0.01
    double wrap_tolerance;    ///< share of R_max that wraps and outer solids may be off; default 0.002
    int32_t solid;            ///< sqmap_solid; SQMAP_SOLID_OUTER leaves repair, accepts_surface and thickness without effect
    const sqmap_paper_options* paper;  ///< may be null
    int32_t without_locator;           ///< not zero: no locator and no exact layer; superquadrics and central maps answer
} sqmap_bake_options;

/// The range of a number among the members of sqmap_bake_options and sqmap_paper_options: "band", "max_q2"; of "nearest_steps" of
/// queries and sessions; also of limits that the program alone sets, as "max_cells". Few rows limit smoothing_radius further. Any
/// thread. Errors: E_ARGUMENT for another name; least and greatest stay as they are.
SQMAP_API sqmap_code sqmap_option_range(const char* name, double* least, double* greatest);

/// Facts of a model; lengths in mesh units.
typedef struct sqmap_facts {
    size_t size;
    double r_max;              ///< largest distance between two vertices
    double band;               ///< within it sqmap_signed_distances is exact
    double centre[3], radius;  ///< of a sphere that holds the object
    uint64_t bytes;            ///< of the model file
    uint32_t parts;
    uint32_t vertices, triangles;  ///< of the baked mesh
    int32_t is_solid;              ///< 0: a surface without inside
    int32_t has_exact;             ///< the triangles are in the model
    int32_t is_normal;             ///< a paper model: baked with projection 1
    int32_t is_doubtful;           ///< layer 3 has wrong verdicts or a depth p99 above 0.5 % of R_max: SQMAP_LAYER_AUTO is exact
    int32_t has_input;             ///< the mesh's own coordinates and numbers are in the model: exact distances are in double
    int32_t cure;                  ///< how the mesh became a solid: 0 as it was given or repaired, 1 closed, 2 wrapped
} sqmap_facts;

/// Maps a model file and verifies it. path: UTF-8.
/// Errors: E_FILE, E_MODEL, E_VERSION. Cost: linear in the file.
SQMAP_API sqmap_code sqmap_open(const char* path, sqmap_model* model);
/// The same of a model in an archive of `sqmap batch`, mapped where it stands. key: 64 hexadecimal digits.
/// Errors: E_FILE for what is no archive, E_ARGUMENT where it holds no such model, E_MODEL, E_VERSION.
SQMAP_API sqmap_code sqmap_open_archived(const char* archive, const char* key, sqmap_model* model);
/// The same of a file's bytes in memory, which are copied. Errors: E_MODEL, E_VERSION.
SQMAP_API sqmap_code sqmap_open_bytes(const void* bytes, size_t size, sqmap_model* model);
/// Bakes triangles. options may be null. The same mesh and options give the same bytes on any number of threads.
/// Errors: E_MESH with the face, vertex or edge and a cure; E_ARGUMENT for options out of range; E_CANCELLED.
/// Cost: seconds for some thousand triangles.
SQMAP_API sqmap_code sqmap_bake(const sqmap_mesh* mesh, const sqmap_bake_options* options, sqmap_model* model);
/// The same of a mesh file: OFF, OBJ, STL, PLY, glTF, GLB. options may be null. Errors: as sqmap_bake; E_FILE where there
/// is none that can be read.
SQMAP_API sqmap_code sqmap_bake_file(const char* path, const sqmap_bake_options* options, sqmap_model* model);
/// Writes the model file; path is never partly written. Errors: E_FILE.
SQMAP_API sqmap_code sqmap_save(sqmap_model model, const char* path);
/// The bytes that sqmap_save writes; valid until the model is closed.
SQMAP_API sqmap_code sqmap_bytes(sqmap_model model, const void** bytes, size_t* size);
/// Facts of a model.
SQMAP_API sqmap_code sqmap_model_facts(sqmap_model model, sqmap_facts* facts);
/// All that `sqmap info --json` prints: parts, certificates, bytes, notes, measured error.
SQMAP_API sqmap_code sqmap_info(sqmap_model model, sqmap_text* json);
/// Notes about the mesh that was baked and about its model, a line each; "notes" of sqmap_info has their numbers. None of a file
/// that was written before there were notes.
SQMAP_API sqmap_code sqmap_notes(sqmap_model model, sqmap_text* lines);
/// Numbers of the baked triangles and vertices in the mesh that was given, -1 of what a cure made (all of a wrapped mesh): as
/// many as sqmap_facts counts; each may be null. Polygons of a file count as one. Errors: E_MISSING of a model without its
/// input.
SQMAP_API sqmap_code sqmap_sources(sqmap_model model, int64_t* triangles, int64_t* vertices);
/// The baked triangles, in the order to which answers refer: vertices (sqmap_facts.vertices x 3), triangles and the part of each
/// (sqmap_facts.triangles x 3 and x 1); each may be null. Coordinates are the caller's own where the model has its input, else
/// rounded to float. Errors: E_MISSING without the exact layer.
SQMAP_API sqmap_code sqmap_triangles(sqmap_model model, double* vertices, uint32_t* triangles, int32_t* parts);
/// Closes a handle; {0} is passed over. What was made of the model goes on working.
SQMAP_API sqmap_code sqmap_close_model(sqmap_model model);

/// Files with shapes that enclose a model's parts.
typedef enum sqmap_format {
    SQMAP_FORMAT_DEFAULT = 0,  ///< as the ending of the file's name says
    SQMAP_FORMAT_URDF = 1,     ///< box, cylinder and sphere; others as meshes in files beside it
    SQMAP_FORMAT_MJCF = 2,     ///< MuJoCo: a free body with a geom a shape
    SQMAP_FORMAT_SDF = 3,      ///< SDFormat 1.9
    SQMAP_FORMAT_SRDF = 4,     ///< MoveIt's link_sphere_approximation: spheres alone
    SQMAP_FORMAT_SPHERES = 5,  ///< cuRobo's YAML: spheres alone
    SQMAP_FORMAT_JSON = 6,     ///< every parameter, and the equation that holds within
    SQMAP_FORMAT_OBJ = 7,      ///< the shapes as triangles
    SQMAP_FORMAT_GLB = 8
} sqmap_format;

/// Shapes that enclose a part.
typedef enum sqmap_shape {
    SQMAP_SHAPE_DEFAULT = 0,  ///< as SQMAP_SHAPE_HULL
    SQMAP_SHAPE_BOX = 1,
    SQMAP_SHAPE_SPHERE = 2,
    SQMAP_SHAPE_ELLIPSOID = 3,
    SQMAP_SHAPE_CAPSULE = 4,
    SQMAP_SHAPE_CYLINDER = 5,
    SQMAP_SHAPE_HULL = 6,
    SQMAP_SHAPE_SUPERQUADRIC = 7
} sqmap_shape;

/// Options of an export. Zero: convex hulls, in the format of the file's ending.
typedef struct sqmap_export_options {
    size_t size;
    int32_t format;    ///< sqmap_format
    int32_t shape;     ///< sqmap_shape
    uint32_t spheres;  ///< 1 to 4096: so many balls hold the whole together, and shape does not count
    uint32_t threads;  ///< 0: one a core; the files do not depend on it
} sqmap_export_options;

/// Encloses each part in a shape that is certified to hold it as it is written, and writes the file and the meshes that it refers
/// to beside it, each whole or not at all. options may be null. report may be null: volumes, support excess and protrusion of
/// each shape and of the whole, as JSON. Lengths are in mesh units. The same as `sqmap export --as`; libsqmap_query lacks it.
/// Errors: E_MISSING without the exact layer; E_ARGUMENT for a shape that the format does not hold, and a name whose ending is of
/// no format; E_FILE. Cost: some 30 ms a part; seconds for balls.
SQMAP_API sqmap_code sqmap_export(sqmap_model model, const char* path, const sqmap_export_options* options, sqmap_text* report);

// ---------------------------------------------------------------------------------------------------- points

/// x in the caller's frame = rotation x + translation. The rotation has to be proper: rows that are off unit and square by 1e-6
/// to 1e-4 are made orthonormal, better ones keep their bits; worse ones, and numbers that are not finite, are refused.
typedef struct sqmap_pose {
    double rotation[9];
    double translation[3];
} sqmap_pose;

/// The layer that answers; each is slower than the one before it, and errs less.
typedef enum sqmap_layer {
    SQMAP_LAYER_DEFAULT = 0,  ///< as SQMAP_LAYER_3
    SQMAP_LAYER_1 = 1,        ///< superquadrics and polytopes: errs towards contact only
    SQMAP_LAYER_2 = 2,        ///< one plane
    SQMAP_LAYER_3 = 3,        ///< planes and maps
    SQMAP_LAYER_EXACT = 4,    ///< the mesh's own triangles
    SQMAP_LAYER_AUTO = 5,     ///< the cheapest whose measured error is within `tolerance`, else exact
    SQMAP_LAYER_GATE = 6      ///< of each part of a paper model 3 where its base map is sparse, else 2
} sqmap_layer;

/// Bits of the status of answers.
enum sqmap_status {
    SQMAP_NOT_FINITE = 1,  ///< the point is NaN or infinite: it is not answered, depth and distance are NaN
    SQMAP_NO_EXACT = 2,    ///< baked without the exact layer, so layer 3 answered: bake with without_exact = 0
    SQMAP_NO_SURFACE = 4,  ///< inside, but no surface is known above: depth 0, normal zero
    SQMAP_FULL = 8,        ///< more contacts than there was space for, the rest is counted: raise sqmap_contact_list::capacity
    SQMAP_MADE_UP = 16,    ///< the mesh was closed or wrapped, and the surface here made up
    SQMAP_NOT_GIVEN = 128  ///< the model's projection does not give what the options name
};

/// How to query. Zero: the default.
typedef struct sqmap_query_options {
    size_t size;
    int32_t layer;          ///< sqmap_layer
    uint32_t threads;       ///< for batches; 0 and 1: this thread alone. The answers do not depend on it
    double tolerance;       ///< of SQMAP_LAYER_AUTO, mesh units; 0: exact
    double margin;          ///< the surface is moved out by so much, mesh units; slower
    double band;            ///< sqmap_signed_distances is exact within it, mesh units; 0: as baked; infinite: everywhere
    int32_t is_smooth;      ///< not zero: depth and normal of the smoothed map
    int32_t is_first_only;  ///< not zero: probes and pairs stop at the first contact
    uint32_t gate;          ///< k_L of SQMAP_LAYER_GATE; 0: 10
    int32_t has_offset;     ///< not zero: the surface moved out by eq. 12
    // Points and probes against paper models. Options that change nothing are refused, as gate is.
    int32_t projector;        ///< sqmap_projector
    int32_t nearest_steps;    ///< to the nearest surface, layer 3, Newton's foot; 0: 2, below 0: none, at most 100
    int32_t without_gaps;     ///< layer 3; not zero: the first surface alone, as printed, not the openings behind it
    int32_t without_pruning;  ///< not zero: any part's claim counts where parts overlap
} sqmap_query_options;

/// Points to be answered.
typedef struct sqmap_points {
    size_t size;
    const double* xyz;  ///< count x 3
    size_t count;
    const sqmap_pose* pose;  ///< of the model in the points' frame; null: the points are in the mesh's own
} sqmap_points;

/// The caller's arrays for the answers, `count` rows each; a null array is not written.
typedef struct sqmap_contacts {
    size_t size;
    uint8_t* contact;  ///< 1: the point is inside
    double* depth;     ///< penetration depth; 0 where free, NaN of a point that is not finite
    double* normal;    ///< x 3: unit, outward at the closest point; zero where free
    double* closest;   ///< x 3: the nearest surface point; the point itself where free
    int32_t* part;     ///< that owns the closest point; -1 where free
    uint8_t* certain;  ///< 1: the verdict is proven
    uint8_t* status;   ///< bits
    size_t contacts;   ///< written: how many points are inside
} sqmap_contacts;

/// Which points are inside, how deep, and in which direction out. options may be null. In float; the exact layer of a solid has
/// contact where sqmap_exact_distances is below zero, to the last bit. A surface that bounds nothing has contact behind it, from
/// where forces push back, and no verdict of it is certain.
/// Cost: 0.1 to 1 us a point; no allocation and no lock on one thread.
SQMAP_API sqmap_code sqmap_query_points(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                                        sqmap_contacts* contacts);

/// How a distance is known.
enum sqmap_known {
    SQMAP_KNOWN_EXACT = 0,
    SQMAP_KNOWN_APPROXIMATE = 1,  ///< by layer 3, of a model without triangles
    SQMAP_KNOWN_BOUND = 2,        ///< the truth has this sign, is no nearer, and at most twice as far
    SQMAP_KNOWN_FLOAT = 3         ///< of sqmap_exact_distances: exact, but in float, of a model without its input
};

/// The caller's arrays for the answers, `count` rows each; a null array is not written.
typedef struct sqmap_distances {
    size_t size;
    double* distance;    ///< to the nearest surface, negative inside; NaN of a point that is not finite
    double* gradient;    ///< x 3: unit, away from the solid; zero of a bound
    double* closest;     ///< x 3: the nearest surface point; the point itself of a bound
    int32_t* part;       ///< that owns it; -1 of a bound
    uint8_t* known;      ///< SQMAP_KNOWN_...
    uint8_t* status;     ///< bits
    uint32_t* triangle;  ///< that holds the closest point, as sqmap_triangles counts; 0xffffffff of a bound
} sqmap_distances;

/// Exact signed distances, in double: of the triangles as the caller gave them, at any distance up to 1e15 times the mesh's size.
/// Errors are some 1e-16 of the coordinates' size. A model without its input answers in float (SQMAP_KNOWN_FLOAT), one without
/// triangles by layer 3 (SQMAP_KNOWN_APPROXIMATE). Of several triangles at that distance the one is named that faces the point
/// most, then the first as they were given. options may be null; only threads is read.
/// Cost: 2 us a point, 5 us ten sizes away; no allocation and no lock on one thread.
SQMAP_API sqmap_code sqmap_exact_distances(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                                           sqmap_distances* distances);
/// Signed distances or bounds of them, in float, for real time: exact to 1e-7 of R_max within options.band, whose default is the
/// baked one (5 % of R_max); beyond it a bound of at least half the distance (SQMAP_KNOWN_BOUND). options may be null; its layer,
/// tolerance, margin and is_smooth are not read.
/// Cost: below 1 us a point in batches; no allocation and no lock on one thread.
SQMAP_API sqmap_code sqmap_signed_distances(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                                            sqmap_distances* distances);

/// The caller's arrays for the answers, `count` rows each; a null array is not written.
typedef struct sqmap_closest {
    size_t size;
    double* closest;     ///< x 3: the nearest point of the triangles; NaN of a point that is not finite
    double* distance;    ///< to it, never negative
    uint32_t* triangle;  ///< its triangle, as sqmap_triangles counts; 0xffffffff of a point that is not finite
} sqmap_closest;

/// The nearest point of the model's triangles in double precision, at any distance, whatever is boundary; of several at that
/// distance the one is named that faces the point most, then the first as they were given. options may be null; only threads is
/// read. Errors: E_MISSING without the exact layer. Cost: the first call builds a tree; then some us a point.
SQMAP_API sqmap_code sqmap_closest_points(sqmap_model model, const sqmap_points* points, const sqmap_query_options* options,
                                          sqmap_closest* closest);

/// F of eq. 1 of a part's superquadric, in double: below 1 within it, 1 on its surface, above 1 outside; NaN of a point that is
/// not finite. It is no distance, and its superquadric holds the part with room to spare. values: points->count; the caller's.
/// Errors: E_ARGUMENT for a part that the model does not have. Cost: 0.1 us a point; no allocation, no lock.
SQMAP_API sqmap_code sqmap_implicit(sqmap_model model, uint32_t part, const sqmap_points* points, double* values);

// ------------------------------------------------------------------------------------------------------------- many poses

/// Poses of a tool, to be answered.
typedef struct sqmap_poses {
    size_t size;
    const sqmap_pose* pose;  ///< count: the tool's frame -> the frame that the model's pose is in
    size_t count;
    uint32_t threads;   ///< 0 and 1: this thread alone. The answers do not depend on it
    double band;        ///< mesh units: farther than this a lower bound suffices; 0: exact everywhere
    int32_t stops;      ///< not zero: a pose is done when one point is found to be as near as stop_below
    double stop_below;  ///< mesh units; read where stops is not zero
} sqmap_poses;

/// The caller's arrays for the answers, a row for each pose; a null array is not written.
typedef struct sqmap_pose_clearances {
    size_t size;
    double* distance;   ///< least signed distance of the tool's points, negative inside; of a bound at most that; NaN of a pose
                        ///< that is not finite
    double* gradient;   ///< x 6: its derivative: by the pose's translation, then by turns about that translation (axis times
                        ///< radians, axes of the frame); zero of a bound
    double* point;      ///< x 3: the tool's point at that distance, the frame of the poses; of a bound the tool's middle
    double* closest;    ///< x 3: the surface point nearest to it; of a bound as point
    int64_t* index;     ///< the point's number, the lowest of several; -1 of a bound
    int32_t* part;      ///< that owns the surface there; -1 of a bound
    uint8_t* known;     ///< SQMAP_KNOWN_...; of SQMAP_KNOWN_BOUND no point is nearer
    uint8_t* complete;  ///< 0: stop_below ended the search, another point may be nearer
    uint8_t* status;    ///< bits
} sqmap_pose_clearances;

/// How near each pose brings a tool to the model: the least signed distance of its points, as sqmap_exact_distances gives it,
/// with its derivative with respect to the pose. Balls about groups of points leave out what cannot be nearest. tool: points in
/// the tool's frame; its pose is that of the model, in the frame that the poses lead to. At creases, where two points are equally
/// near, the derivative is that of one side. Errors: E_ARGUMENT for a tool without points or with one that is not finite, and for
/// a rotation that is none; a pose with a number that is not finite has NaN for an answer, the others stay right. Cost: 45
/// to 100 us a pose for 500 points, 1 to 21 with a narrow band; allocates.
SQMAP_API sqmap_code sqmap_query_poses(sqmap_model model, const sqmap_points* tool, const sqmap_poses* poses,
                                       sqmap_pose_clearances* clearances);

// ---------------------------------------------------------------------------------------------------- probes and pairs

/// Points prepared once, queried many times: the vertices of a tool. {0} is none.
typedef struct sqmap_probe {
    uint64_t id;
} sqmap_probe;

/// Prepares a probe; points.pose is not read. Errors: E_ARGUMENT for a point that is not finite. Cost: n log n.
SQMAP_API sqmap_code sqmap_make_probe(const sqmap_points* points, sqmap_probe* probe);
/// Closes a handle; {0} is passed over.
SQMAP_API sqmap_code sqmap_close_probe(sqmap_probe probe);

/// A point of a probe inside a model, in the frame of the poses.
typedef struct sqmap_contact {
    float point[3];   ///< the nearest surface point, from sqmap_contact_list.anchor
    float normal[3];  ///< unit, outward
    float depth;      ///< penetration depth
    uint32_t index;   ///< of the probe's point
    int16_t part;     ///< of the model
    uint8_t certain;  ///< 1: the verdict is proven
    uint8_t status;   ///< bits
} sqmap_contact;

/// Contacts of a probe.
typedef struct sqmap_contact_list {
    size_t size;
    sqmap_contact* contacts;  ///< space for `capacity`; the caller's
    size_t capacity;
    size_t found;      ///< written: contacts there are; at most `capacity` of them stand in `contacts`
    double anchor[3];  ///< written: what points are relative to
    uint32_t status;   ///< written: bits
} sqmap_contact_list;

/// A body in the frame of the poses: its model is touched, its probe touches. Both are of one mesh. Either may be {0} where a
/// call does not need it.
typedef struct sqmap_body {
    sqmap_model model;
    sqmap_probe probe;
    const sqmap_pose* pose;  ///< mesh frame -> that of the poses; null: the same
} sqmap_body;

/// Two bodies.
typedef struct sqmap_bodies {
    size_t size;
    sqmap_body a, b;
} sqmap_bodies;

/// Which points of b's probe are inside a's model. options may be null. Errors: E_HANDLE without a's model or b's probe.
/// Cost: microseconds for thousands of points; no allocation, no lock.
SQMAP_API sqmap_code sqmap_query_probe(const sqmap_bodies* bodies, const sqmap_query_options* options,
                                       sqmap_contact_list* contacts);

/// A vertex of one body in the other, in the frame of the poses.
typedef struct sqmap_pair_contact {
    double on_a[3], on_b[3];  ///< on_b = on_a - depth normal
    float normal[3];          ///< unit, the direction in which b leaves a
    float depth;
    uint32_t index;     ///< of the vertex in its body's probe
    int16_t part;       ///< of the other body's model
    uint8_t vertex_of;  ///< 0: of a, 1: of b
    uint8_t certain;    ///< 1: the verdict is proven
    uint8_t is_mutual;  ///< 1: seen from both sides
    uint8_t status;     ///< bits
} sqmap_pair_contact;

/// Memory that pair queries compute in: one for each thread. {0} is none.
typedef struct sqmap_workspace {
    uint64_t id;
} sqmap_workspace;

/// Contacts of a pair.
typedef struct sqmap_pair_list {
    size_t size;
    const sqmap_pair_contact* contacts;  ///< written: in the workspace, valid until its next query
    size_t count;                        ///< written
    size_t found;                        ///< written: in both directions, before those seen twice were merged
    uint32_t status;                     ///< written: bits
    /// Written: edges no longer than this that cross the other surface have an end among the contacts: twice the margin, less
    /// what rounding takes. 0: edges are missed.
    double edge_length;
} sqmap_pair_list;

/// contacts: the largest number that is found in one direction; what is beyond it is counted. Allocates.
SQMAP_API sqmap_code sqmap_make_workspace(size_t contacts, sqmap_workspace* workspace);
/// Closes a handle; {0} is passed over.
SQMAP_API sqmap_code sqmap_close_workspace(sqmap_workspace workspace);
/// Contacts of two bodies: each one's probe in the other's model, each contact once; one direction alone where the other lacks
/// model or probe. options may be null. Errors: E_HANDLE where both directions lack one.
/// Cost: two probe queries; no allocation, no lock.
SQMAP_API sqmap_code sqmap_query_pair(const sqmap_bodies* bodies, const sqmap_query_options* options, sqmap_workspace workspace,
                                      sqmap_pair_list* contacts);

// ------------------------------------------------------------------------------------------------- complete contacts

/// Prepares the vertices of a closed mesh and the triangles between them, which complete contacts need: a probe as
/// sqmap_make_probe gives it, that knows its triangles besides. Vertices at the same position count as one.
/// Errors: E_ARGUMENT for a vertex that is not finite or a number that names none; E_MESH for triangles that are open, turned
/// round or of a shell that is inside out, with the triangle and a cure, and where the diagonal of their box is not from 1e-9 to
/// 1e12. Cost: n log n, and n for each cavity.
SQMAP_API sqmap_code sqmap_make_solid_probe(const sqmap_mesh* mesh, sqmap_probe* probe);

/// The element of a mesh that takes part in a contact.
enum sqmap_feature { SQMAP_VERTEX = 0, SQMAP_EDGE = 1, SQMAP_FACE = 2 };

/// A contact of two bodies, in the frame of the poses.
typedef struct sqmap_surface_contact {
    double on_a[3], on_b[3];  ///< on_b = on_a - depth normal
    float normal[3];          ///< unit, the direction in which b leaves a
    /// A vertex has its distance to the other surface, or along the normal to a face that bears it; others what separates the two
    /// features.
    float depth;
    uint8_t feature_a, feature_b;  ///< sqmap_feature
    /// A vertex or a face by its number in the body's probe; an edge as 3 t + k, from corner k of triangle t to the next one.
    /// 0xffffffff: the face that a vertex is below.
    uint32_t index_a, index_b;
    /// Contacts of one region touch together; 0xffffffff: a vertex that no face bears, while per_region is 0.
    uint32_t region;
    int16_t part_a, part_b;  ///< of the bodies' models; -1: none
    uint8_t certain;         ///< 1: the verdict is proven
    uint8_t status;          ///< bits
} sqmap_surface_contact;

/// Which contacts are wanted. Zero: all.
typedef struct sqmap_contact_options {
    size_t size;
    uint32_t per_region;    ///< of a region the deepest is kept and those that span the largest area; 0: all
    int32_t is_first_only;  ///< not zero: stop at the first contact
} sqmap_contact_options;

/// Complete contacts of a pair.
typedef struct sqmap_surface_list {
    size_t size;
    const sqmap_surface_contact* contacts;  ///< written: in the workspace, valid until its next query
    size_t count;                           ///< written
    size_t found;                           ///< written: kept or not
    size_t meetings;                        ///< written: pairs of triangles that have a point in common
    size_t regions;                         ///< written: each has a contact
    uint32_t status;                        ///< written: bits
} sqmap_surface_list;

/// Contacts of two closed meshes, none missed: vertices in the other body's model, edges against edges, faces. Where triangles of
/// both meshes have a point in common, their region has a contact. options may be null; where a model is {0}, no vertices in it
/// are found. Errors: E_HANDLE without both probes; E_MISSING for a probe of sqmap_make_probe, which has no triangles.
/// Cost: microseconds for thousands of triangles; the first call with a workspace allocates, no other one does.
SQMAP_API sqmap_code sqmap_query_contacts(const sqmap_bodies* bodies, const sqmap_contact_options* options,
                                          sqmap_workspace workspace, sqmap_surface_list* contacts);

/// The first touch of two bodies.
typedef struct sqmap_touch {
    size_t size;
    double time;                   ///< written: share of the motion, not after the first touch; 1 where there is none
    int32_t touches;               ///< written: 1 or 0
    uint32_t status;               ///< written: bits
    const sqmap_pose* end_pose_a;  ///< where a moves to, as b does; null: a rests
} sqmap_touch;

/// When b, which moves from its pose to end_pose in a straight line and about one axis, touches a, which rests or moves to
/// touch.end_pose_a in the same time; bodies that touch at the beginning do so at time 0. Never late; early by at most a
/// thousandth of the motion where surfaces approach at 8 degrees or steeper. Errors: as sqmap_query_contacts. Cost: some queries
/// of contacts; no allocation.
SQMAP_API sqmap_code sqmap_first_touch(const sqmap_bodies* bodies, const sqmap_pose* end_pose, sqmap_touch* touch);

/// Points and triangles, or edges and edges, that move in straight lines at a steady rate.
typedef struct sqmap_moving_features {
    size_t size;
    const double* start;  ///< 12 count, at time 0: a point and the triangle's corners, or the ends of one edge, then of the other
    const double* end;    ///< 12 count, at time 1
    size_t count;
    int32_t are_edges;  ///< 0: points against triangles; else edges against edges
    double separation;  ///< touching: at most this far apart
} sqmap_moving_features;

/// First touches of features, each `count` long; each may be null.
typedef struct sqmap_touches {
    size_t size;
    double* time;      ///< not after the first touch; 1 where there is none
    uint8_t* touches;  ///< 1 or 0
} sqmap_touches;

/// When each two features first touch. Never missed nor late, early by 1e-9 where they do not pass at grazing distance; with a
/// coordinate that is not finite they touch at time 0. Errors: E_ARGUMENT for features.separation below zero or NaN. Cost: a
/// tenth of a microsecond in the median for two that stay apart, some ten for two that come close; no allocation.
SQMAP_API sqmap_code sqmap_first_touch_features(const sqmap_moving_features* features, sqmap_touches* touches);

/// The least distance of two solids, in the frame and units of the poses.
typedef struct sqmap_clearance {
    size_t size;
    double within;                    ///< 0: the distance is computed; above 0: is_within alone, which stops early
    double distance;                  ///< written: of the two points; 0 where the solids have a point in common
    double at_least;                  ///< written: the truth is not below it; some 1e-14 of the sizes below the distance
    double on_a[3], on_b[3];          ///< written: the nearest points
    uint32_t triangle_a, triangle_b;  ///< written: that hold them; 0xffffffff where one solid is in the other
    int32_t is_within;                ///< written where within is above 0: 1 where the solids are at most so far apart
    uint32_t status;                  ///< written: bits
} sqmap_clearance;

/// How far two closed meshes are apart. One within the other is found by their models; a body whose model is {0} has no inside.
/// Errors: as sqmap_query_contacts; E_ARGUMENT for clearance.within below zero or NaN. Cost: tens of microseconds for thousands
/// of triangles, fewer with within; no allocation.
SQMAP_API sqmap_code sqmap_query_clearance(const sqmap_bodies* bodies, sqmap_clearance* clearance);

/// How much two solids share.
typedef struct sqmap_overlap {
    size_t size;
    double volume;    ///< written: of the intersection, in the cube of the poses' unit
    double error;     ///< written: what the shift of faces in special position changes at most, without rounding
    uint32_t status;  ///< written: bits
} sqmap_overlap;

/// Volume of the intersection of two closed meshes, exact from their triangles. Errors: as sqmap_query_contacts. Cost: linear in
/// all triangles; allocates where the workspace has not yet computed an overlap of meshes as large.
SQMAP_API sqmap_code sqmap_query_overlap(const sqmap_bodies* bodies, sqmap_workspace workspace, sqmap_overlap* overlap);

/// How far b has to be moved until it is free of a, in the frame and units of the poses.
typedef struct sqmap_separation {
    size_t size;
    double along[3];      ///< the direction, of any length; 0, 0, 0: the shortest translation that is known, in any direction
    double distance;      ///< written: along the direction; then they only touch; 0 where they have no point in common
    double at_least;      ///< written: no shorter translation of those in question separates them
    double direction[3];  ///< written: unit
    int32_t is_exact;     ///< written: 1 where the two bounds differ by rounding alone
    uint32_t status;      ///< written: bits
} sqmap_separation;

/// The translation of b that separates two closed meshes: along a direction to the first gap that is wider than 2e-9 of their
/// sizes, by exact predicates; or the shortest that is known, of two convex solids the least of all, of others the least among
/// that of their hulls and those along the normals of their contacts. Errors: as sqmap_query_contacts; E_ARGUMENT for a direction
/// that is not finite. Cost: a millisecond for thousands of triangles along a direction, some ten without one; allocates where
/// the workspace has not yet served meshes as large.
SQMAP_API sqmap_code sqmap_query_separation(const sqmap_bodies* bodies, sqmap_workspace workspace, sqmap_separation* separation);

// ---------------------------------------------------------------------------------------------------- many bodies

/// Many bodies in one world that move; for one thread at a time. {0} is none.
typedef struct sqmap_pile {
    uint64_t id;
} sqmap_pile;

/// contacts: of a pair in one direction, for which there is space at first; it grows where a pair has more. Allocates.
SQMAP_API sqmap_code sqmap_make_pile(size_t contacts, sqmap_pile* pile);
/// Closes a handle; {0} is passed over.
SQMAP_API sqmap_code sqmap_close_pile(sqmap_pile pile);
/// Adds a body and gives it a number: the lowest that is free. body.probe has triangles; body.model may be {0}. The pile keeps
/// both: the handles may be closed. Errors: E_MISSING for a probe of sqmap_make_probe.
SQMAP_API sqmap_code sqmap_add_body(sqmap_pile pile, const sqmap_body* body, uint32_t* number);
/// Errors: E_ARGUMENT where no body has the number.
SQMAP_API sqmap_code sqmap_remove_body(sqmap_pile pile, uint32_t number);

/// A step of a pile: the bodies' new poses, and the contacts that are wanted.
typedef struct sqmap_pile_step {
    size_t size;
    const sqmap_pose* pose;  ///< count: pose i of body i; null: all stay
    size_t count;            ///< bodies from this number on stay; at most one more than the largest number given so far
    uint32_t threads;        ///< 0 and 1: this thread alone. The answers do not depend on it
    uint32_t per_region;     ///< as in sqmap_contact_options
    int32_t is_first_only;   ///< not zero: of each pair the first contact
} sqmap_pile_step;

/// Two bodies of a pile that touch.
typedef struct sqmap_pile_pair {
    uint32_t a, b;             ///< numbers of the bodies, a < b
    size_t first, count;       ///< of the contacts: contacts[first] to contacts[first + count - 1]
    size_t found;              ///< kept or not
    size_t meetings, regions;  ///< as in sqmap_surface_list
    uint8_t status;            ///< bits; the bytes behind it are zero
} sqmap_pile_pair;

/// Contacts of a pile.
typedef struct sqmap_pile_contacts {
    size_t size;
    const sqmap_pile_pair* pairs;           ///< written: in the order of a, then b; the pile's, valid until its next query
    const sqmap_surface_contact* contacts;  ///< written: pair after pair, each as sqmap_query_contacts gives them
    size_t pair_count;                      ///< written
    size_t count;                           ///< written
    size_t near;                            ///< written: pairs whose spheres touch
    uint32_t status;                        ///< written: bits of all
} sqmap_pile_contacts;

/// Complete contacts of all pairs of bodies that are near each other, to the bit those of each pair alone. Which bodies are near
/// is kept from one query to the next. step may be null. A body whose pose has a number that is not finite is near nothing, and
/// the status says so. Errors: E_ARGUMENT for a rotation that is none, and for more poses than numbers of bodies. Cost:
/// sqmap_query_contacts of each pair, shared by the threads; allocates where there are more pairs or contacts than ever before.
SQMAP_API sqmap_code sqmap_query_pile(sqmap_pile pile, const sqmap_pile_step* step, sqmap_pile_contacts* contacts);

// ---------------------------------------------------------------------------------------------------- forces

/// A tool that touches a model, and the safety filter before its device. Metres, newtons, seconds. {0} is none.
/// This is research software, not a safety device.
typedef struct sqmap_session {
    uint64_t id;
} sqmap_session;

/// How the tool follows the device.
typedef enum sqmap_mode {
    SQMAP_MODE_DEFAULT = 0,  ///< as SQMAP_MODE_DIRECT
    SQMAP_MODE_DIRECT = 1,   ///< the tool is where the device is
    SQMAP_MODE_PROXY = 2,    ///< a proxy stays on the surface, and the device pulls it: for thin parts and deep presses
    SQMAP_MODE_COUPLED = 3   ///< a simulated body, joined to the device by springs and dampers that a light stylus carries
} sqmap_mode;

/// How contacts become a force.
typedef enum sqmap_force_law {
    SQMAP_FORCE_FULL = 0,  ///< to the nearest surface, smoothed about the point, full across edges
    SQMAP_FORCE_PAPER = 1  ///< eqs. 21, 26 and 32 on the smoothed map of a paper model, with SQMAP_MODE_DIRECT
} sqmap_force_law;

/// The friction of a session.
typedef enum sqmap_friction_law {
    SQMAP_FRICTION_DEFAULT = 0,  ///< eq. 33 with SQMAP_FORCE_PAPER, else Coulomb's
    SQMAP_FRICTION_COULOMB = 1,
    SQMAP_FRICTION_PAPER = 2,  ///< eq. 33, with f_c and k_f
    SQMAP_FRICTION_NONE = 3
} sqmap_friction_law;

/// How the foot of a point is found on a paper model.
typedef enum sqmap_projector {
    SQMAP_PROJECTOR_NEWTON = 0,   ///< the exact foot
    SQMAP_PROJECTOR_PYRAMID = 1,  ///< the search of eqs. 16 to 19, corrected
    SQMAP_PROJECTOR_PRINTED = 2   ///< to the letter; the paper's force then has eq. 21's depth, on the map of the layer
} sqmap_projector;

/// The touched model, the tool and the limits of the device. Zero: the default.
typedef struct sqmap_session_options {
    size_t size;
    double metres_per_unit;   ///< of the mesh; default 1
    const sqmap_pose* pose;   ///< of the model in the world, its translation in metres; null: at the origin
    double radius;            ///< of the tool, a ball, m; 0: a point
    double stiffness;         ///< N/m; default 500
    double damping;           ///< N s/m along the normal
    double friction;          ///< Coulomb's, static; dynamic is three quarters of it; default 0.4, below 0: none
    int32_t layer;            ///< sqmap_layer, 1 is answered by 2
    double max_force;         ///< of the device, N; 0: unknown, 1 N
    double max_torque;        ///< of the device, N m; 0: unknown, 0.05 N m
    double continuous_force;  ///< of the device, N, root mean square over 10 s; 0: unknown
    double force_limit;       ///< of the user, N; 0: 2 N or the device's, whichever is less
    double torque_limit;      ///< of the user, N m; 0: 0.1 N m or the device's, whichever is less
    int32_t has_dead_man;     ///< not zero: force only while sqmap_tick.acts has SQMAP_TICK_HELD
    double side_path;         ///< m, of the proxy. 0: it goes round what is thinner than the press is deep. Above 0 it stays on
                              ///< its side of that, and takes another as the device moves so far across the surface
    int32_t mode;             ///< sqmap_mode
    int32_t force;            ///< sqmap_force_law
    int32_t friction_law;     ///< sqmap_friction_law
    double f_c;               ///< N, of eq. 33; 0: 0.2, below 0: none
    double k_f;               ///< 1/m, of eq. 33; 0: 100, below 0: none
    // Paper models; others take the defaults alone. Options that change nothing are refused, as gate is.
    int32_t projector;        ///< sqmap_projector
    uint32_t gate;            ///< k_L of SQMAP_LAYER_GATE; 0: 10
    int32_t nearest_steps;    ///< to the nearest surface, layer 3, Newton's foot; 0: 2, below 0: none, at most 100
    int32_t without_gaps;     ///< not zero: the first surface alone, as printed, not the openings behind it
    int32_t without_pruning;  ///< not zero: any part's claim counts where parts overlap
    int32_t has_offset;       ///< not zero: the surface moved out by eq. 12
    sqmap_probe tool;         ///< with triangles, metres, the tool's frame: its surface touches in place of a ball; it may be
                              ///< closed once the session is made. {0}: the ball
    int32_t without_edges;    ///< not zero: the tool's points alone touch. 0: where few points do, its edges and faces do too,
                              ///< which the model needs the exact layer and a closed surface for
    double zone;              ///< m, of a tool: the impact sphere about its pose, whose contacts count (section 6.1); 0: all
} sqmap_session_options;

/// Bits of sqmap_tick.acts.
enum sqmap_act {
    SQMAP_TICK_STOP = 1,          ///< zero from now on, until SQMAP_TICK_RESUME
    SQMAP_TICK_RESUME = 2,        ///< the user's act: clears STOP and faults
    SQMAP_TICK_RESTART = 4,       ///< the scene changed: forces begin anew
    SQMAP_TICK_HELD = 8,          ///< the dead-man switch is held
    SQMAP_TICK_DISCONNECTED = 16  ///< the device is gone
};

/// One reading of the device.
typedef struct sqmap_tick {
    size_t size;
    double time;         ///< s, monotonic: now
    double sample_time;  ///< s, the same clock: when the device was read
    uint64_t sequence;   ///< grows by one with every fresh reading: the same number is a stale one
    sqmap_pose pose;     ///< of the tool in the world, metres
    uint32_t acts;       ///< bits of SQMAP_TICK_...
} sqmap_tick;

/// The answer of a tick.
typedef struct sqmap_force {
    size_t size;
    double force[3], torque[3];  ///< for the device: N, N m about the tool, world axes; finite, within the limits
    double commanded[3];         ///< N, before the safety filter
    double depth;                ///< m; of a proxy the stretch of its spring
    double normal[3];            ///< unit, outward; zero where free
    uint32_t status;             ///< bits of haptic::StepStatus: 1 contact, 4 not finite, 256 teleport
    uint32_t acted;              ///< bits of haptic::SafetyStep: 1 something is not finite, or the pose no rotation
    uint32_t faults;             ///< bits of haptic::SafetyFault; any of them means zero until the user resumes
    int32_t is_engaged;          ///< all that is commanded is sent, within limits
    sqmap_pose tool;             ///< where the tool is, world, m: the device's pose, the proxy's or the coupled body's
} sqmap_force;

/// A session on a model. options may be null, options.tool may be {0}. Errors: E_ARGUMENT with the number and its range; limits
/// that a filter refuses; E_MISSING for a tool without triangles, or with edges and a model without the exact layer.
SQMAP_API sqmap_code sqmap_make_session(sqmap_model model, const sqmap_session_options* options, sqmap_session* session);
/// One tick: a pose in, the wrench for the device out. Where the call fails, and wherever anything is not finite, stale or
/// faulty, or a pose is no rotation, force and torque are zero. No allocation, no lock. One thread at a time a session.
/// Cost: some ten microseconds.
SQMAP_API sqmap_code sqmap_tick_session(sqmap_session session, const sqmap_tick* tick, sqmap_force* force);

/// A simulated stylus of 70 g in a hand that holds it as a pen; ticks of 1 ms, no clock. Rows of three doubles; results may be
/// null.
typedef struct sqmap_simulation {
    size_t size;
    const double* targets;  ///< count x 3: where the hand wants to be at each tick, m
    size_t count;
    double* positions;  ///< count x 3: where the stylus is, m
    double* forces;     ///< count x 3: sent, N
    double* depths;     ///< count: m
    double* tools;      ///< count x 3: where the tool is, m: sqmap_force.tool
} sqmap_simulation;

/// Drives the session with a simulated device, in a time of its own that goes on from call to call.
SQMAP_API sqmap_code sqmap_simulate(sqmap_session session, const sqmap_simulation* simulation);
/// Closes a handle; {0} is passed over.
SQMAP_API sqmap_code sqmap_close_session(sqmap_session session);

// ---------------------------------------------------------------------------------------------------- tactile pads

/// Taxels that touch models: normal and shear force of each. {0} is none.
typedef struct sqmap_pad {
    uint64_t id;
} sqmap_pad;

/// Forces of a taxel, in the units of the mesh's lengths and of the stiffness; the names are TacSL's. Zero: the default.
typedef struct sqmap_pad_options {
    size_t size;
    double tactile_kn;       ///< force per penetration depth; default 1
    double tactile_kt;       ///< force per speed of slip, up to Coulomb's limit; default 0.1, below 0: none
    double tactile_mu;       ///< Coulomb's coefficient; default 0.5, below 0: none
    double tactile_damping;  ///< force per speed along the surface's normal
    int32_t layer;           ///< sqmap_layer
} sqmap_pad_options;

/// One tick. Slip is the motion of a taxel over the model since the tick before.
typedef struct sqmap_pad_tick {
    size_t size;
    sqmap_model model;             ///< that is touched
    const sqmap_pose* model_pose;  ///< mesh frame -> that of the poses; null: the same
    const sqmap_pose* pose;        ///< of the pad; null: the same frame
    double dt;                     ///< since the tick before, s; 0: no slip
    int32_t restarts;              ///< not zero: the pad was lifted and set elsewhere, no slip
} sqmap_pad_tick;

/// The forces that a taxel measures, in the pad's frame.
typedef struct sqmap_taxel {
    float normal;    ///< pressed in, never negative
    float shear[3];  ///< perpendicular to the taxel's normal
    float depth;     ///< penetration depth; 0 where free
} sqmap_taxel;

/// Taxels of a tick.
typedef struct sqmap_taxels {
    size_t size;
    sqmap_taxel* taxels;         ///< space for `count`, in the order of the points; the caller's
    size_t count;                ///< as many as the pad has points
    size_t contacts;             ///< written: taxels inside the model
    double force[3], torque[3];  ///< written: on the pad, about its origin, in its frame
    uint32_t status;             ///< written: bits
} sqmap_taxels;

/// Prepares a pad. points: of the taxels, in the pad's frame, points.pose is not read; normals: outward, as many rows of three
/// doubles. options may be null. Errors: E_ARGUMENT for what is not finite. Cost: n log n.
SQMAP_API sqmap_code sqmap_make_pad(const sqmap_points* points, const double* normals, const sqmap_pad_options* options,
                                    sqmap_pad* pad);
/// One tick. One thread at a time a pad. Cost: 20 us for 1,000 taxels that touch, twice that without AVX-512; no
/// allocation, no lock.
SQMAP_API sqmap_code sqmap_tick_pad(sqmap_pad pad, const sqmap_pad_tick* tick, sqmap_taxels* taxels);
/// Closes a handle; {0} is passed over.
SQMAP_API sqmap_code sqmap_close_pad(sqmap_pad pad);

#ifdef __cplusplus
}
#endif
