#include "sqmap/io/soup.h"
