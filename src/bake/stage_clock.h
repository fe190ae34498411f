// CPU time of the process, told stage by stage.
#pragma once

#include <ctime>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::bake {

class StageClock {
public:
    /// Appends the name and what was spent since the last lap, in seconds.
    void lap(const char* stage, std::vector<std::pair<std::string, double>>& seconds)
    {
        const double now = cpu_seconds();
        seconds.emplace_back(stage, now - last_);
        last_ = now;
    }

private:
    static double cpu_seconds()
    {
        timespec t{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }

    double last_ = cpu_seconds();
};

}  // namespace sqmap::bake
