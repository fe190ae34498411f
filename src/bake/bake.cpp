#include "sqmap/bake/bake.h"
