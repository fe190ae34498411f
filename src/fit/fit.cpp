#include "sqmap/fit/fit.h"
