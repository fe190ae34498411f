// The addresses at which the page fetches an object: bytes to draw, and files to save.
#pragma once

#include "viewer/server/http/routes.h"
#include "viewer/server/jobs/worker.h"
#include "viewer/server/scene/scene.h"

namespace sqmap::viewer {

/// Adds the addresses /api/object/N/... ; all three must outlive the routes' last answer.
void add_downloads(Routes& routes, const Scene& scene, Worker& pictures);

}  // namespace sqmap::viewer
