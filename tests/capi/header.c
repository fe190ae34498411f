/* The header is C11 and C++ without a warning; the sizes that another compiler has to agree with. */
#include <sqmap.h>
#ifdef __cplusplus
#define CHECK(condition) static_assert(condition, "size")
#else
#define CHECK(condition) _Static_assert(condition, "size")
#endif
CHECK(sizeof(sqmap_model) == 8);
CHECK(sizeof(sqmap_contact) == 36);
CHECK(sizeof(sqmap_pair_contact) == 80);
CHECK(sizeof(sqmap_pose) == 96);
const char* sqmap_test_version(void);
const char* sqmap_test_version(void) { return sqmap_version(); }
