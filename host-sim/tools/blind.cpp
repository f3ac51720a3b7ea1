#include <memory>

#include "host-sim/blind/blind_set.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {
namespace {

struct Generate {
  blind::SetRequest request;
  std::string out;
  Output output;
};

int generate(Generate& options) {
  require_folder(options.out);
  options.request.folder = options.out;
  {
    Progress progress("making blind cases");
    blind::write_set(options.request, std::ref(progress));
  }
  options.output.print("{} cases in {}, labels sealed in {}/labels\n", options.request.cases, options.out,
                       options.out);
  options.output.finish({{"folder", options.out},
                         {"cases", options.request.cases},
                         {"seed", options.request.seed},
                         {"kind", options.request.kind},
                         {"tier", options.request.tier}});
  return kDone;
}

CLI::App* declare_generate(CLI::App& blind, Generate& options) {
  CLI::App* app =
      blind.add_subcommand("generate", "Make cases whose cause is sealed, by an independent simulation");
  auto& request = options.request;
  app->add_option("--out", options.out, "New folder for the set")->type_name("DIR")->required();
  app->add_option("--cases", request.cases, "How many")->check(CLI::Range(1, 9999))->capture_default_str();
  app->add_option("--seed", request.seed, "The same seed gives the same bytes")->capture_default_str();
  app->add_option("--kind", request.kind, "one, many (two or three), none, unknown (in no catalogue), all")
      ->check(CLI::IsMember({"one", "many", "none", "unknown", "all"}))
      ->capture_default_str();
  app->add_option("--tier", request.tier,
                  "1 mixed, volume moving; 2 mixed, volume fixed; 3 a single chirp; all")
      ->check(CLI::IsMember({"1", "2", "3", "all"}))
      ->capture_default_str();
  app->add_option("--effect", request.effect, "This effect in every case, instead of all in turn")
      ->type_name("ID");
  app->add_option("--seconds", request.seconds, "Length of each log [s]; the held-out one is 0.6 of it")
      ->check(CLI::Range(10.0, 100.0))
      ->capture_default_str();
  options.output.add_to(*app);
  app->footer(
      example("  plenum blind generate --out set --cases 300 --seed 7    # set/case-0001 .. and set/labels"));
  return app;
}

}  // namespace

Command add_blind(CLI::App& program) {
  CLI::App* app = program.add_subcommand("blind", "Check a diagnosis on cases whose cause is withheld");
  app->require_subcommand(1);
  const auto options = std::make_shared<Generate>();
  const CLI::App* make = declare_generate(*app, *options);
  static_cast<void>(make);
  app->footer(example("  plenum blind generate --out set --cases 100"));
  return {app, [options] { return generate(*options); }};
}

}  // namespace plenum::host::tools
