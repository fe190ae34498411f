// All that a program of the runtime needs: models, queries of points, distances, probes, pairs, contacts, scenes, skins, forces.
// <sqmap/bake_mesh.h> makes a model, <sqmap/io/model_file.h> reads one; devices and cloth have headers of their own.
#pragma once

// IWYU pragma: begin_exports
#include "sqmap/haptic/patch.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/step.h"
#include "sqmap/haptic/stiffness.h"
#include "sqmap/haptic/tactile.h"
#include "sqmap/haptic/tool.h"
#include "sqmap/math/pose.h"
#include "sqmap/math/rotation.h"
#include "sqmap/model/model.h"
#include "sqmap/model/parse.h"
#include "sqmap/query/clearance.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/first_touch.h"
#include "sqmap/query/overlap.h"
#include "sqmap/query/pair.h"
#include "sqmap/query/point.h"
#include "sqmap/query/probe.h"
#include "sqmap/query/probe_workspace.h"
#include "sqmap/query/scene.h"
#include "sqmap/query/separating.h"
#include "sqmap/query/skin.h"
#include "sqmap/query/swept.h"
// IWYU pragma: end_exports
