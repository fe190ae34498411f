// Names and types of MuJoCo 3 that sqmap's plugin uses, for a test without MuJoCo 3.
#pragma once

#include <stdint.h>

typedef double mjtNum;
typedef struct mjModel_ mjModel;
typedef struct mjData_ {
    uintptr_t* plugin_data;
} mjData;

void mju_warning(const char* format, ...);
const char* mj_getPluginConfig(const mjModel* m, int instance, const char* attribute);

enum { mjPLUGIN_SDF = 8 };

typedef struct mjpPlugin_ {
    const char* name;
    int nattribute;
    const char* const* attributes;
    int capabilityflags;
    int (*nstate)(const mjModel* m, int instance);
    int (*init)(const mjModel* m, mjData* d, int instance);
    void (*copy)(mjData* to, const mjModel* m, const mjData* from, int instance);
    void (*reset)(const mjModel* m, mjtNum* state, void* data, int instance);
    void (*compute)(const mjModel* m, mjData* d, int instance, int capability);
    mjtNum (*sdf_distance)(const mjtNum point[3], const mjData* d, int instance);
    void (*sdf_gradient)(mjtNum gradient[3], const mjtNum point[3], const mjData* d, int instance);
    mjtNum (*sdf_staticdistance)(const mjtNum point[3], const mjtNum* attributes);
    void (*sdf_attribute)(mjtNum attribute[], const char* name[], const char* value[]);
    void (*sdf_aabb)(mjtNum aabb[6], const mjtNum* attributes);
} mjpPlugin;

void mjp_defaultPlugin(mjpPlugin* plugin);
int mjp_registerPlugin(const mjpPlugin* plugin);
