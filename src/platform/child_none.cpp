// Systems on which no other program is started.
#include "child.h"

namespace sqmap::platform {

std::string program_on_path(std::string_view) { return {}; }
PrivateFolder::PrivateFolder() = default;
PrivateFolder::~PrivateFolder() = default;
ChildResult run(Command) { return {}; }

}  // namespace sqmap::platform
