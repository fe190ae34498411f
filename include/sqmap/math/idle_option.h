// An option that was changed and changes nothing. The rules stand beside the options; each program and interface refuses or warns
// with the option's name as it has it. Plain data: any thread.
#pragma once

namespace sqmap {

/// The option, the reason and the cure.
struct IdleOption {
    const char* name;  ///< as in C and Python: "nearest_steps"
    const char* why;   ///< after the name: "counts with ..."
    const char* cure;  ///< an imperative, with other options' names in quotes: "set 'layer' to gate"
};

}  // namespace sqmap
