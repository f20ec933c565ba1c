"""The layer check: every include in tumble/ goes to the left in tumble/layers.txt, and every name has one home.

A line of tumble/layers.txt is a module; a room of math/ is a module too. Headers that stand directly in a module are its
face: they name no heavy library, and what they declare is in namespace tumble. Headers in a folder below a module are in
namespace tumble::<folder>, and are internal to the module. Two kinds serve all modules to the right: those that help
with a heavy library (math/eigen/ and core/tables/, for .cpp files and folders), and the rooms of reduce/, which several methods share.
Helpers of tests (testing/) serve all tests. No method includes a header of another method. No two headers define a type of one name in one namespace.

The digits of a constant stand in tumble/units alone: code of tumble/ and apps/, but for tests, uses tumble/units/constants.hpp.

No code of tumble/ and apps/, but for tests, searches or cuts text: values travel as values, and what this program wrote for people is never
read again. Those who read text are formats, wire, units and plan files, the reader of old results, and the files of READS_TEXT, each
with its reason.

    check_layers.py REPOSITORY      exit 1 and one line a fault
    check_layers.py --self-test     a sound small tree passes, and every kind of tampering with it is caught
"""

import re

import check_tools

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
GENERATED = {"tumble/version.hpp"}
ALL = "tumble/tumble.hpp"  # names the headers that are promised to users of the library
SHARED = ("tumble/math/eigen/", "tumble/core/tables/")  # between our types and a heavy library
ROOMS = "tumble/reduce/"  # what several methods share
NAMESPACE = re.compile(r"^(?:inline )?namespace ([a-z][\w:]*) \{")
DEFINITION = re.compile(r"^(?:struct|class|enum class|enum) (?:alignas\(\w+\) )?(\w+)[^;]*$")
METHODS_THAT_BUILD_ON = {("imu_channel_calibration", "accelerometer_four_position")}  # the split test is that method
LITERAL_OR_COMMENT = re.compile(r'"(?:\\.|[^"\\])*"|//.*')
PI = r"(?:std::numbers::)?\bpi\b"
CONSTANTS = (  # what is not written outside of tumble/units, and the name to use
    (re.compile(r"(?<![\w.])9\.80665"), "standard_gravity or micro_g"),
    (re.compile(r"\bM_PI"), "pi, two_pi or half_pi"),
    (re.compile(rf"(?<![\w.])180(?:\.0?)? */ *{PI}|{PI} */ *180(?:\.0?)?(?![\w.])"), "degree or degrees_per_radian"),
    (re.compile(r"(?<![\w.])3600(?:\.0?)?(?![\w.])"), "hour"),
)
TEXT = re.compile(r"\b(?:starts_with|ends_with|substr|remove_prefix|remove_suffix|from_chars|find_(?:first|last)(?:_not)?_of|getline|"
                  r"istringstream|sscanf|strto[dfilu]+|sto(?:[dfil]|ul|ll|ull|ld))\b|(?:::|\.)npos\b|\bstd::regex|\bfind\('")
ROOMS_OF_TEXT = ("tumble/formats/", "tumble/wire/", "tumble/units/", "tumble/tasks/plan_file/", "tumble/core/tables/",
                 "tumble/report/legacy/")
READS_TEXT = {  # why: which files, below tumble/ and apps/
    "sentences: patterns, their places and the tables of translations are made of text":
        "tumble/core/finding.cpp tumble/language/said.cpp tumble/language/said/pattern.cpp tumble/language/said/stored.cpp tumble/language/say.cpp",
    "settings and options, as people write them":
        "tumble/core/settings.cpp tumble/methods/imu_channel_calibration/evidence.cpp tumble/methods/imu_ferraris/sections.cpp "
        "tumble/methods/random_vibration/types.cpp tumble/methods/rlg_lock_in/sweep.cpp tumble/tasks/export.cpp "
        "tumble/tasks/fleet/limits.cpp tumble/tasks/load_lab.cpp tumble/tasks/sets.cpp tumble/tasks/stopping_rule.cpp",
    "names of equipment, as people write them, and of errors, which begin alike":
        "tumble/reduce/rig_keys.cpp",
    "the text of a plan, which the form changes and leaves its comments as they are":
        "tumble/tasks/plan_edit.cpp",
    "the first lines of a file say what it is":
        "tumble/report/image.cpp tumble/report/image/fault.cpp tumble/serve/result_cache.cpp tumble/tasks/kind_of_file.cpp",
    "the file of a station: requirements, addresses, dates":
        "tumble/station/conduct/parts.cpp tumble/station/link/address.cpp tumble/station/link/open.cpp "
        "tumble/station/requirement.cpp tumble/station/station_file/devices.cpp tumble/station/station_file/read.cpp",
    "dates and times in ISO 8601":
        "tumble/core/instant.cpp",
    "names of channels in files of others say their sensor and their axis":
        "tumble/checks/support/signals.cpp tumble/checks/units.cpp tumble/core/evidence.cpp tumble/core/roles.cpp tumble/exchange/assembly/noise.cpp "
        "tumble/reduce/compensation/inputs.cpp tumble/reduce/vibration/data.cpp tumble/report/names.cpp "
        "tumble/tasks/gather.cpp",
    "the channel .compensation_sd beside a channel, in a recording that was written before":
        "tumble/reduce/compensate.cpp tumble/tasks/compensation_report.cpp",
    "lays out lines, cells, numbers and units for a page or a terminal":
        "apps/cli/live_block.cpp tumble/exchange/certificate/tables.cpp tumble/exchange/certificate/typography.cpp "
        "tumble/report/figure/ticks.cpp tumble/report/html/html_parameters.cpp tumble/report/html/html_tables.cpp "
        "tumble/report/html/html_text.cpp tumble/report/parameter_rows.cpp tumble/report/rounding.cpp tumble/report/text.cpp "
        "tumble/report/text_table.cpp tumble/report/typeset.cpp tumble/report/utf8.cpp",
    "writes a file of another program, whose rules are about characters":
        "tumble/exchange/certificate/xml.cpp tumble/exchange/exports/ardupilot.cpp tumble/exchange/exports/c.cpp "
        "tumble/exchange/exports/c_code/model.cpp tumble/exchange/exports/export.cpp tumble/exchange/exports/writing/text.cpp "
        "tumble/report/figure/csv.cpp tumble/report/json_write.cpp tumble/serve/routes/views.cpp",
    "the rules of certificates: codes of countries, addresses, numbers, the document itself":
        "tumble/exchange/certificate/countries.cpp tumble/exchange/certificate/dcc_rules.cpp "
        "tumble/exchange/certificate/details.cpp tumble/exchange/certificate_number.cpp",
    "bytes, not text: a buffer is taken from its front":
        "apps/cli/live_output.cpp tumble/archive/storage/packing.cpp tumble/math/state.hpp tumble/pyramid/live_samples.cpp "
        "tumble/station/conduct/device_line.cpp tumble/station/conduct/flood_watch.cpp tumble/recorder/live_store/chunk.cpp "
        "tumble/rehearsal/virtual_stream.cpp tumble/rehearsal/virtual_switch.cpp",
    "what a device answers is searched for what its declaration expects":
        "tumble/station/conduct/stream_line.cpp tumble/station/executive/devices.cpp",
    "addresses and statements of databases, characters that they cannot hold":
        "tumble/archive/archive.cpp tumble/archive/database/database.cpp tumble/archive/database/postgres.cpp "
        "tumble/archive/deposits/read_result.cpp tumble/archive/schema/migrations.cpp tumble/archive/schema/shape.cpp "
        "tumble/serve/routes/archive.cpp tumble/serve/routes/archive_charts.cpp",
    "MODEL/SERIAL and kinds of certificates in the archive":
        "tumble/archive/history.cpp tumble/serve/routes/archive_certificates.cpp",
    "HTTP: targets, headers, queries, cookies, types":
        "tumble/serve/guard.cpp tumble/serve/http/target.cpp tumble/serve/passwords.cpp tumble/serve/routes/plan_files.cpp "
        "tumble/serve/routes/jobs.cpp tumble/serve/routes/pages.cpp tumble/serve/routes/result_json.cpp",
    "names of files and folders":
        "tumble/report/json_read.cpp tumble/serve/folder_paths.cpp tumble/serve/jobs.cpp tumble/serve/jobs/folder_below.cpp "
        "tumble/serve/routes/recordings.cpp tumble/serve/routes/station.cpp tumble/serve/workbench.cpp "
        "tumble/tasks/fleet_summary.cpp tumble/tasks/identify.cpp",
    "lines that our own processes hand to each other, and their small files":
        "tumble/serve/jobs/process.cpp tumble/serve/recording_cache.cpp tumble/serve/routes/spoken.cpp "
        "tumble/desk/desk_client.cpp tumble/station/guard.cpp tumble/station/lease/claim.cpp tumble/station/lease/names.cpp "
        "tumble/desk/run_desk.cpp",
    "the command line and what is typed":
        "apps/cli/command_line.cpp apps/cli/completion.cpp apps/cli/password.cpp apps/cli/run.cpp apps/cli/serve.cpp "
        "apps/cli/standard_input.cpp apps/cli/terminal.cpp apps/cli/typed_lines.cpp",
    "`rate.2` of the protocol of a controller is the rate of its axis 2":
        "tumble/rehearsal/virtual_bench.cpp",
    "results of before, which have no error models":
        "tumble/report/error_model/legacy.cpp",
    "two texts of results are compared, except for folders before names of files":
        "tumble/tasks/recompute.cpp",
    "the unit that an output has is part of the text of a further unit":
        "tumble/methods/imu_ferraris/report.cpp",
}
# Heavy libraries: a header that names one makes every file that includes it pay, and ties our interface to theirs.
HEAVY = ("Eigen/", "nlohmann/", "toml++/", "boost/", "hdf5", "H5", "openssl/", "CLI/", "zlib", "bzlib", "lz4", "zstd",
         "sqlite3", "pugixml", "libpq")


def module_of(parts, layers):
    """The module of a path below tumble/, given as its parts: the longest one that layers.txt names; None without one."""
    for length in (2, 1):
        name = "/".join(parts[:length])
        if len(parts) > length and name in layers:
            return name
    return None


def fault_of_include(layer, layers, quoted, target, is_face):
    """What is wrong with one include of a file in `layer`, or None."""
    if is_face and not quoted and target.startswith(HEAVY):
        return f"header includes <{target}>: keep it in the .cpp"
    if target.startswith("apps/"):
        return f'includes "{target}": the library knows no front end'
    if not target.startswith("tumble/"):
        return f'includes "{target}": write our own headers from the root ("tumble/...")' if quoted else None
    if target in GENERATED:
        return None
    parts = target.split("/")[1:]
    other = module_of(parts, layers)
    if other is None:
        return f'includes "{target}": {parts[0]} is not in tumble/layers.txt'
    if layers.index(other) > layers.index(layer):
        return f'includes "{target}": {layer} stands before {other} in tumble/layers.txt'
    internal = len(parts) > other.count("/") + 2
    if not internal or "testing" in parts or target.startswith(ROOMS):
        return None
    if is_face or (other != layer and not target.startswith(SHARED)):
        return f'includes "{target}": headers in a subfolder are internal to {other}'
    return None


def fault_between_methods(relative, target):
    """What is wrong with one include of a file of a method, or None."""
    mine, other = relative.parts[2], target.split("/")
    if relative.name.endswith("_test.cpp"):
        return None
    if relative.parts[1] != "methods" or len(relative.parts) < 4 or mine == "testing" or len(other) < 4:
        return None
    if other[1] != "methods" or other[2] in (mine, "testing") or (mine, other[2]) in METHODS_THAT_BUILD_ON:
        return None
    return f'includes "{target}": what two methods share stands in reduce/'


def faults_of_namespace(relative, lines, layer, types):
    """Faults of the namespaces of one header; adds the types that it defines to `types`, with where."""
    depth = layer.count("/") + 2
    folder = relative.parts[-2] if len(relative.parts) > depth + 1 else ""
    wanted = "tumble" + (f"::{folder}" if folder else "")
    constants = f"tumble::{relative.stem}"  # a table of constants may have a namespace of its own
    above = f"tumble::{relative.parts[-3]}" if folder == "testing" else wanted  # helpers of what stands in the folder above
    faults, current = [], None
    for number, line in enumerate(lines, 1):
        opened = NAMESPACE.match(line)
        if opened and not (current and opened[1] == "detail"):
            current = opened[1]
            forward = current == "tumble" and folder  # forward declarations of types of other modules
            if current not in (wanted, constants, above) and not forward and current not in ("std", "Eigen"):
                faults.append(f"{relative}:{number}: is in namespace {current}, by its folder it belongs in {wanted}")
        defined = DEFINITION.match(line)
        if defined and current == "tumble" and folder and folder != "testing":
            faults.append(f"{relative}:{number}: defines {defined[1]} in namespace tumble, by its folder it belongs in {wanted}")
        if defined and current:
            types.setdefault((current, defined[1]), []).append(f"{relative}:{number}")
    return faults


def faults_of_constants(root):
    """Constants written as digits in code, outside of tumble/units and of tests."""
    faults = []
    for path in sorted(p for folder in ("tumble", "apps") for p in (root / folder).rglob("*.[ch]pp")):
        relative = path.relative_to(root)
        if relative.parts[:2] == ("tumble", "units") or path.stem.endswith("_test") or "testing" in relative.parts:
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            code = LITERAL_OR_COMMENT.sub("", line)
            for pattern, name in CONSTANTS:
                if digits := pattern.search(code):
                    faults.append(f"{relative}:{number}: writes {digits[0]}: use {name} of tumble/units/constants.hpp")
    return faults


def faults_of_text(root, readers):
    """Files that search or cut text and are not listed, and those that are listed and do not."""
    reading = {}
    for path in sorted(p for folder in ("tumble", "apps") for p in (root / folder).rglob("*.[ch]pp")):
        relative = path.relative_to(root)
        if relative.as_posix().startswith(ROOMS_OF_TEXT) or path.stem.endswith("_test") or "testing" in relative.parts:
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if found := TEXT.search(LITERAL_OR_COMMENT.sub("", line)):
                reading.setdefault(relative.as_posix(), f"{relative}:{number}: searches or cuts text ({found[0]})")
    listed = {file for files in readers.values() for file in files.split()}
    faults = [f"{fault}: pass values, or give the reason in tests/check_layers.py" for file, fault in reading.items() if file not in listed]
    return faults + [f"{file}: is in READS_TEXT of tests/check_layers.py, and reads no text" for file in sorted(listed - set(reading))]


def check(root, readers=READS_TEXT):
    """All faults of the tree under `root`, as lines 'file:line: what'."""
    layers = (root / "tumble/layers.txt").read_text().split()
    files = sorted(p for p in (root / "tumble").rglob("*") if p.suffix in (".hpp", ".cpp"))
    faults = [] if files else [f"{root}/tumble: no source file found"]
    types = {}
    for path in files:
        relative = path.relative_to(root)
        if relative.as_posix() == ALL:
            continue
        layer = module_of(relative.parts[1:], layers)
        if layer is None:
            faults.append(f"{relative}: {relative.parts[1]} is not in tumble/layers.txt")
            continue
        is_face = path.suffix == ".hpp" and len(relative.parts) == layer.count("/") + 3
        lines = path.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines, 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            fault = fault_of_include(layer, layers, match[1] == '"', match[2], is_face)
            fault = fault or fault_between_methods(relative, match[2])
            if fault:
                faults.append(f"{relative}:{number}: {fault}")
        if path.suffix == ".hpp":
            faults += faults_of_namespace(relative, lines, layer, types)
    for (space, name), places in sorted(types.items()):
        if len(places) > 1:
            faults.append(f"{places[1]}: {space}::{name} is defined at {places[0]} too")
    return faults + faults_of_constants(root) + faults_of_text(root, readers)


SOUND = {
    "tumble/layers.txt": "units\nmath\nmath/noise\ncore\nreduce\nmethods\nformats\n",
    "tumble/math/noise/model.hpp": '#include "tumble/math/fit.hpp"\nnamespace tumble {\nstruct Model {\n};\n'
                                   "struct alignas(64) Line {\n};\nstruct alignas(64) Pair {\n};\n}\n",
    "tumble/math/noise/part/deep.hpp": "namespace tumble {\nstruct Model;\n}\nnamespace tumble::part {\nstruct Model {\n};\n}\n",
    "tumble/reduce/rows/rows.hpp": "namespace tumble::rows {\n}\n",
    "tumble/methods/bias/bias.cpp": '#include "tumble/reduce/rows/rows.hpp"\n#include "tumble/methods/bias/part.hpp"\n',
    "tumble/units/unit.hpp": "#pragma once\n#include <string>\n",
    "tumble/math/fit.hpp": '#pragma once\n#include "tumble/units/unit.hpp"\n',
    "tumble/math/fit.cpp": '#include "tumble/math/fit.hpp"\n#include <Eigen/Dense>\n#include "tumble/version.hpp"\n',
    "tumble/core/part/deep.cpp": '#include "tumble/math/fit.hpp"\n#include "tumble/core/part/deep.hpp"\n',
    "tumble/core/part/deep.hpp": '#include <hdf5.h>\n#include "tumble/math/eigen/view.hpp"\n',
    "tumble/core/shared.cpp": '#include "tumble/math/eigen/view.hpp"\n',
    "tumble/units/constants.hpp": "namespace tumble {\ninline constexpr double g = 9.80665, hour = 3600.0;\n}\n",
    "tumble/core/constants_test.cpp": "EXPECT_EQ(g, 9.80665);\nconstexpr double degree = 180.0 / M_PI;\n",
    "tumble/core/testing/place.hpp": "namespace tumble::testing {\nconstexpr double g = 9.80665;\n}\n",
    "tumble/core/words.cpp": 'say("3600 s, \\"9.80665"); // 9.80665, M_PI\nx = 13600.0 + 3600.5 + 180.0 / pitch + 1e3600;\n',
    "tumble/formats/read.cpp": "auto at = text.find(\'x\'); text.substr(at);\n",
    "tumble/core/listed.cpp": "auto at = text.find(\'x\'); // find(\'\n",
    "tumble/core/find.cpp": 'auto found = map.find(key); say("substr(", found != map.end());\n',
    "tumble/core/read_test.cpp": "EXPECT_TRUE(text.starts_with(start));\n",
    "apps/cli/main.cpp": '#include "tumble/core/any.hpp"\n#include "apps/cli/verbs.hpp"\n',
}
READERS = {"it may": "tumble/core/listed.cpp"}
TAMPERED = {  # file, its new text, words of the fault
    "climbs": ("tumble/units/unit.hpp", '#include "tumble/math/fit.hpp"\n', "units stands before math"),
    "climbs from a subfolder": ("tumble/math/a/b.cpp", ' #  include "tumble/core/any.hpp"\n', "math stands before core"),
    "climbs in angle brackets": ("tumble/units/unit.hpp", "#include <tumble/core/any.hpp>\n", "units stands before core"),
    "knows a front end": ("tumble/core/x.cpp", '#include "apps/cli/verbs.hpp"\n', "no front end"),
    "Eigen in a header": ("tumble/math/fit.hpp", "#include <Eigen/Core>\n", "keep it in the .cpp"),
    "nlohmann in a header": ("tumble/core/x.hpp", "#include <nlohmann/json.hpp>\n", "keep it in the .cpp"),
    "toml++ in a header": ("tumble/core/x.hpp", "#include <toml++/toml.h>\n", "keep it in the .cpp"),
    "HDF5 in a header": ("tumble/core/x.hpp", "#include <hdf5.h>\n", "keep it in the .cpp"),
    "relative include": ("tumble/math/fit.cpp", '#include "fit.hpp"\n', "from the root"),
    "internal header of another module": ("tumble/core/x.cpp", '#include "tumble/math/a/b.hpp"\n', "internal to math"),
    "Eigen's view in a face": ("tumble/core/x.hpp", '#include "tumble/math/eigen/view.hpp"\n', "internal to math"),
    "internal header in a face": ("tumble/core/x.hpp", '#include "tumble/core/part/deep.hpp"\n', "internal to core"),
    "a room that climbs": ("tumble/math/fit.hpp", '#include "tumble/math/noise/model.hpp"\n', "math stands before math/noise"),
    "internal header of a room": ("tumble/core/x.cpp", '#include "tumble/math/noise/part/deep.hpp"\n', "internal to math/noise"),
    "face outside of tumble": ("tumble/core/x.hpp", "namespace tumble::core {\n", "belongs in tumble"),
    "folder outside of its namespace": ("tumble/reduce/rows/y.hpp", "namespace tumble::lines {\n", "belongs in tumble::rows"),
    "a type above its folder": ("tumble/reduce/rows/y.hpp", "namespace tumble {\nstruct Row {\n", "belongs in tumble::rows"),
    "a type defined twice": ("tumble/core/x.hpp", "namespace tumble {\nstruct Model {\n", "defined at"),
    "one method in another": ("tumble/methods/noise/x.cpp", '#include "tumble/methods/bias/part.hpp"\n', "reduce/"),
    "gravity in digits": ("tumble/core/x.cpp", 'say("g"); double g = -9.80665; // m/s^2\n', "writes 9.80665"),
    "a part of gravity in digits": ("tumble/core/x.cpp", "double ug = 9.80665e-6;\n", "micro_g"),
    "gravity in the digits of a front end": ("apps/cli/x.cpp", "return a / 9.80665;\n", "standard_gravity"),
    "pi of the C library": ("tumble/math/fit.cpp", "return 2.0 * M_PI * f;\n", "writes M_PI"),
    "half of the C library's pi": ("tumble/math/fit.cpp", "return M_PI_2;\n", "writes M_PI"),
    "degrees a radian": ("tumble/core/x.cpp", "return angle * 180.0 / std::numbers::pi;\n", "degrees_per_radian"),
    "radians a degree": ("tumble/core/x.hpp", "namespace tumble {\nconstexpr double d = pi / 180;\n}\n", "degree"),
    "seconds an hour": ("tumble/core/x.cpp", "return seconds / 3600.0;\n", "use hour"),
    "seconds an hour as an integer": ("tumble/core/x.cpp", "return 3600 * hours;\n", "use hour"),
    "text searched": ("tumble/core/x.cpp", "if (at == text.npos) return;\n", "searches or cuts text (.npos)"),
    "text cut in a front end": ("apps/cli/x.cpp", "name = text.substr(2);\n", "searches or cuts text (substr)"),
    "a number read": ("tumble/core/x.hpp", "namespace tumble {\nint n = std::stoi(text);\n}\n", "pass values"),
    "a listed file that reads no text": ("tumble/core/listed.cpp", "int at = 0;\n", "reads no text"),
    "unlisted module": ("tumble/extra/x.cpp", "\n", "extra is not in"),
    "include of an unlisted module": ("tumble/core/x.cpp", '#include "tumble/extra/x.hpp"\n', "extra is not in"),
}


def self_test():
    with check_tools.tree_of({"tumble/layers.txt": "units\n"}) as root:
        empty = check(root, {})
    failures = check_tools.faults_of_tampering(lambda root: check(root, READERS), SOUND, TAMPERED)
    if len(empty) != 1 or "no source file" not in empty[0]:
        failures.append(f"a tree without sources gives {empty}")
    return failures


if __name__ == "__main__":
    check_tools.main(__doc__, lambda root: (check(root), ""), self_test, "layer check passed")
