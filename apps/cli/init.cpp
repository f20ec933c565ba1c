#include <filesystem>
#include <memory>

#include "tumble/formats/atomic_file.hpp"
#include "tumble/tasks/ready_plans.hpp"
#include "tumble/units/error.hpp"
#include "verbs.hpp"

namespace tumble::cli {
namespace {

struct InitArguments {
  std::string name, output;
};

/// The plans that this one names, into its folder; one that is there stays as it is.
void write_plans_beside(const ReadyPlan& plan, const std::string& output, const Terminal& terminal) {
  for (const auto& file : plan.beside) {
    const auto path = (std::filesystem::path(output).parent_path() / file).string();
    if (std::filesystem::exists(path)) continue;
    const auto& other = find_ready_plan(std::filesystem::path(file).stem().string());
    write_file_atomically(path, std::string(other.text));
    note(terminal, say("wrote {}: {}", Name{path}, other.title));
  }
}

int run(const InitArguments& arguments, const Terminal& terminal) {
  const ReadyPlan& plan = find_ready_plan(arguments.name);
  if (arguments.output.empty()) {
    print(std::string(plan.text));
    return 0;
  }
  check_output("-o", arguments.output, {}, {".toml"});
  if (std::filesystem::exists(arguments.output))
    throw Error(Error::Kind::bad_input, say("-o {}: the file is there already; choose another name", arguments.output));
  write_file_atomically(arguments.output, std::string(plan.text));
  note(terminal, say("wrote {}: {}", Name{arguments.output}, plan.title));
  write_plans_beside(plan, arguments.output, terminal);
  return 0;
}

}  // namespace

Verb init_verb() {
  auto arguments = std::make_shared<InitArguments>();
  return {"init",
          "Write a commented plan to start from",
          {{"METHOD|PLAN", &arguments->name, "a method, or a plan of `tumble list plans`", true},
           {"-o,--output", &arguments->output, "plan to write (.toml); without it the plan is printed"}},
          "Examples:\n"
          "  tumble init fog_thermal_bias -o my_gyro.toml\n"
          "  tumble simulate my_gyro.toml -o rehearsal.h5 && tumble identify my_gyro.toml rehearsal.h5\n",
          [arguments](const Terminal& terminal) { return run(*arguments, terminal); }};
}

}  // namespace tumble::cli
