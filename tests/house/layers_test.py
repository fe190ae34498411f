#!/usr/bin/env python3
"""check_layers.py finds what it must find: a check that passes everything checks nothing."""
import checked

COMMON = {
    "docs/architecture.md": "```\nsqmap check mesh.obj\n```\n\n```\nmath < shape < model < query < sim\nmodel < io\nshape < bake\nquery < bake\n"
                            "bake < apps/common < apps/sqmap\napps/common < bench\n```\n",
    "src/io/soup.h": "", "include/sqmap/io/soup.h": "", "include/sqmap/shape/superquadric.h": "", "include/sqmap/query/point.h": "",
    "apps/common/layer.h": "", "apps/sqmap/touch.h": "", "bench/path.h": "", "src/math/vec.h": "",
}
CASES = [
    ("an include of a folder to the right", {"src/shape/a.cpp": '#include "io/soup.h"\n'}, "shape/ must not include io/"),
    ("the same through a relative path", {"src/shape/a.cpp": '#include "../io/soup.h"\n'}, "shape/ must not include io/"),
    ("in a public header", {"include/sqmap/math/a.h": '#include "sqmap/shape/superquadric.h"\n'}, "math/ must not include shape/"),
    ("in a sub-folder", {"src/shape/deep/a.cpp": '#include "sqmap/io/soup.h"\n'}, "shape/ must not include io/"),
    ("a comment is no include", {"include/sqmap/math/a.h": '// #include "sqmap/shape/superquadric.h"\n'}, None),
    ("neighbours in no order", {"src/sim/a.cpp": '#include "sqmap/io/soup.h"\n'}, "sim/ must not include io/"),
    ("what the order allows, two steps away", {"src/bake/a.cpp": '#include "math/vec.h"\n#include "sqmap/query/point.h"\n'}, None),
    ("a folder without a place", {"src/elsewhere/a.cpp": ""}, "'elsewhere' has no place"),
    ("an app that includes another", {"apps/common/a.cpp": '#include "sqmap/touch.h"\n'}, "apps/common/ must not include apps/sqmap/"),
    ("a bench that includes an app", {"bench/a.cpp": '#include "apps/sqmap/touch.h"\n', "bench/b.cpp": '#include "layer.h"\n'}, None),
    ("the same by a path that is found", {"bench/a.cpp": '#include "../apps/sqmap/touch.h"\n'}, "bench/ must not include apps/sqmap/"),
    ("a public header that is gone", {"src/sim/a.cpp": '#include "sqmap/shape/gone.h"\n'}, "there is no public header sqmap/shape/gone.h"),
    ("the same in a test", {"tests/a.cpp": '#include "sqmap/shape/gone.h"\n'}, "tests/a.cpp: there is no public header"),
    ("no list of the order", {"docs/architecture.md": "nothing\n"}, "no list of the order"),
    ("an order among sub-folders", {"docs/architecture.md": "```\nmath < query\nquery/chart < query/scene\n```\n", "src/io/soup.h": "",
                                    "src/query/chart/a.h": '#include "query/scene/b.h"\n', "src/query/scene/b.h": ""},
     "query/chart/ must not include query/scene/"),
    ("two sub-folders that include one another",
     {"src/query/chart/a.h": '#include "query/scene/b.h"\n', "src/query/chart/c.h": "", "src/query/scene/b.h": "",
      "src/query/scene/d.h": '#include "query/chart/c.h"\n'}, "knot of query/chart, query/scene"),
    ("a knot of three",
     {"src/query/a/a.h": '#include "query/b/b.h"\n', "src/query/b/b.h": '#include "query/c/c.h"\n', "src/query/c/c.h": '#include "query/a/x.h"\n',
      "src/query/a/x.h": ""}, "knot of query/a, query/b, query/c"),
    ("a public header counts where its source is",
     {"include/sqmap/query/pair.h": '#include "sqmap/query/probe.h"\n', "src/query/scene/pair.cpp": '#include "sqmap/query/pair.h"\n', "include/sqmap/query/probe.h": "",
      "src/query/chart/probe.cpp": '#include "sqmap/query/probe.h"\n#include "sqmap/query/pair.h"\n'}, "knot of query/chart, query/scene"),
    ("a public header counts with the source that joins sub-folders",
     {"include/sqmap/query/all.h": "", "src/query/all.cpp": '#include "sqmap/query/all.h"\n#include "query/chart/a.h"\n',
      "src/query/chart/a.h": '#include "sqmap/query/all.h"\n'}, "knot of query/chart, src/query/all.cpp"),
    ("headers beside the sub-folders and the source that joins these are no knot",
     {"src/query/shared.h": "", "src/query/chart/a.h": '#include "query/shared.h"\n', "src/query/all.cpp": '#include "query/chart/a.h"\n'}, None),
    ("a room's header whose source is one level up counts with it",
     {"src/query/chart/answer.h": "", "src/query/answer.cpp": '#include "query/chart/answer.h"\n#include "query/exact/a.h"\n',
      "src/query/exact/a.h": '#include "query/chart/answer.h"\n'}, "knot of query/chart, query/exact"),
    ("so does one whose functions a source of another name defines",
     {"src/query/chart/a.h": "int answer(int x);\n", "src/query/all.cpp": '#include "query/chart/a.h"\n#include "query/exact/a.h"\n'
      "int answer(int x) { return x; }\n", "src/query/exact/a.h": '#include "query/chart/a.h"\n'}, "knot of query/chart, query/exact"),
    ("modules of the package that import one another",
     {"python/sqmap/_a.py": "from ._b import f\n", "python/sqmap/_b.py": "def f():\n    from . import _a\n"},
     "knot of python/sqmap/_a.py, python/sqmap/_b.py"),
    ("modules of the page that import one another",
     {"apps/viewer/web/src/net.ts": "import {\n  f,\n} from './program/a';\n", "apps/viewer/web/src/program/a.ts": "import type { G } from '../net';\n"},
     "knot of apps/viewer/web/src/net.ts, apps/viewer/web/src/program/a.ts"),
    ("a target that compiles another folder's file", {"bench/CMakeLists.txt": "add_executable(b main.cpp ../apps/sqmap/image.cpp)\n"},
     "b compiles apps/sqmap/image.cpp"),
    ("a file that two targets compile", {"bench/CMakeLists.txt": "add_executable(b a.cpp)\nadd_executable(c a.cpp)\n"}, "compiled by b, c"),
    ("libraries that link one another",
     {"src/CMakeLists.txt": "target_link_libraries(sqmap_io PUBLIC sqmap::build)\ntarget_link_libraries(sqmap_build PRIVATE sqmap_io)\n"},
     "knot of targets: sqmap_build, sqmap_io"),
]
# The include by a name that only a folder's own search path could find is not one of the project's.
checked.run("check_layers.py", CASES, COMMON)
