// Contacts of sqmap inside MuJoCo 2.2: pairs of meshes are answered by the meshes themselves instead of their convex hulls.
//
//   sqmap_mujoco* override;
//   if (sqmap_mujoco_install(model, NULL, &override) != SQMAP_OK) puts(sqmap_last_error()->message);
//   while (...) mj_step(model, data);
//   sqmap_mujoco_remove(override);
//
// MuJoCo's table of collision functions is one for the process: install and remove while no simulation steps. Models are told
// apart by their address. Two threads may step two mjData of one mjModel.
#pragma once

#include <mujoco/mujoco.h>
#include <sqmap.h>

#ifdef __cplusplus
extern "C" {
#endif

/// How to bake and query. Zero: the default.
typedef struct sqmap_mujoco_options {
    size_t size;
    int32_t layer;         ///< sqmap_layer; default SQMAP_LAYER_EXACT
    int32_t max_contacts;  ///< of a pair, 1 to mjMAXCONPAIR; default mjMAXCONPAIR
    const char* folder;    ///< where baked models are kept from run to run; null: nowhere
    /// Not zero: contacts of edges and faces too, none missed, of pairs whose meshes are both closed; layer and margins of geoms
    /// are not read for them.
    int32_t is_complete;
} sqmap_mujoco_options;

/// One installed model.
typedef struct sqmap_mujoco sqmap_mujoco;

/// Bakes every mesh that a geom collides with, from mjModel's own arrays, and answers pairs of them from now on. options may be
/// null. A mesh that sqmap refuses keeps MuJoCo's hull. Errors: E_ARGUMENT; E_MESH of the first mesh where all are refused.
/// Cost: seconds a mesh.
sqmap_code sqmap_mujoco_install(const mjModel* model, const sqmap_mujoco_options* options, sqmap_mujoco** override);
/// Meshes that are answered by sqmap.
int sqmap_mujoco_meshes(const sqmap_mujoco* override);
/// Gives pairs back to MuJoCo and frees everything; null is passed over.
void sqmap_mujoco_remove(sqmap_mujoco* override);

#ifdef __cplusplus
}
#endif
