#include "sqmap/decompose/decompose.h"
