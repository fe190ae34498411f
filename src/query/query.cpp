#include "sqmap/query/query.h"
