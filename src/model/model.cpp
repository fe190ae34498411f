#include "sqmap/model/model.h"
