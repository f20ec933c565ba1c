#include <memory>

#include "tumble/report/report.hpp"
#include "verbs.hpp"

namespace tumble::cli {

Verb add_predict(CLI::App& program) {
  struct Arguments {
    std::string plan;
    std::vector<std::string> sets;
    bool json = false;
  };
  auto* app = program.add_subcommand("predict", "The uncertainty of every parameter before the test is run");
  auto arguments = std::make_shared<Arguments>();
  app->add_option("PLAN", arguments->plan, "plan file (.toml) with [rig], [[schedule]] and [truth]")->required();
  app->add_flag("--json", arguments->json, "print JSON instead of a table");
  add_sets(*app, arguments->sets, "in place of what the plan says: KEY, truth.KEY, rig.KEY; repeatable");
  app->footer("Example:\n  tumble predict fog.toml\n");
  return {app, [arguments](const Terminal&) {
            const auto estimate = tasks::predict(tasks::load_plan(arguments->plan, parse_sets(arguments->sets)));
            print(arguments->json ? to_json(estimate) : to_text(estimate));
            return 0;
          }};
}

}  // namespace tumble::cli
