#include <memory>

#include "host-sim/blind/blind_set.hpp"
#include "host-sim/blind/score.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

struct Generate {
  blind::SetRequest request;
  std::string out;
  Output output;
};

int generate(Generate& options) {
  static_cast<void>(
      blind::recipe_of(options.request, 0));  // contradictions are told before any folder is made
  require_folder(options.out);
  options.request.folder = options.out;
  {
    Progress progress("making blind cases");
    blind::write_set(options.request, std::ref(progress));
  }
  options.output.print("{} cases in {}, their labels in {}/labels\n", options.request.cases, options.out,
                       options.out);
  options.output.finish({{"folder", options.out},
                         {"cases", options.request.cases},
                         {"seed", options.request.seed},
                         {"kind", options.request.kind},
                         {"tier", options.request.tier}});
  return kDone;
}

Arguments declare(Arguments& blind, Generate& options) {
  Arguments arguments =
      blind.command("generate", "Make cases whose cause is sealed, by an independent simulation");
  auto& request = options.request;
  arguments.option("--out", options.out, "New folder for the set").type_name("DIR").required();
  arguments.option("--cases", request.cases, "How many").within(1, 9999).show_default();
  arguments.option("--seed", request.seed, "The same seed gives the same bytes").show_default();
  arguments.option("--kind", request.kind, "one, many (two or three), none, unknown (in no catalogue), all")
      .one_of({"one", "many", "none", "unknown", "all"})
      .show_default();
  arguments
      .option("--tier", request.tier, "1 mixed, volume moving; 2 mixed, volume fixed; 3 a single chirp; all")
      .one_of({"1", "2", "3", "all"})
      .show_default();
  arguments.option("--effect", request.effect, "This effect in every case, instead of all in turn")
      .type_name("ID");
  arguments.option("--seconds", request.seconds, "Length of each log [s]; the held-out one is 0.6 of it")
      .within(10.0, 100.0)
      .show_default();
  options.output.add_to(arguments);
  arguments.footer(example(
      "  plenum blind generate --out set --cases 300 --seed 7    # set/case-0001 and so on, set/labels"));
  return arguments;
}

struct Score {
  std::string set;
  std::string answers;
  double detectable = blind::kDetectable;
  Output output;
};

std::string share(const Json& value) {
  if (value.at("percent").is_null()) return "  no case";
  return fmt::format("{:6.1f} %  ({} of {})", value.at("percent").get<double>(),
                     value.at("right").get<unsigned>(), value.at("of").get<unsigned>());
}

std::string figure(const Json& value, const char* unit) {
  return value.is_null() ? "  no case" : fmt::format("{:6.3g}{}", value.get<double>(), unit);
}

void print_score(const Output& output, const Json& result) {
  output.print("{} cases, {} without an answer\n", result.at("cases").get<unsigned>(),
               result.at("missing_answers").get<unsigned>());
  for (const auto& [tier, value] : result.at("top1_percent").items()) {
    output.print("{:<28} {}\n", fmt::format("first name right, {}", tier), share(value));
  }
  output.print("{:<28} {}\n", "one name alone right", share(result.at("singleton_correct_percent")));
  output.print("{:<28} {}\n", "truth in the set named", share(result.at("coverage_percent")));
  output.print("{:<28} {}\n", "two or three, F1", figure(result.at("multi_f1").at("f1"), ""));
  output.print("{:<28} {}\n", "false alarm", share(result.at("false_alarm_percent")));
  output.print("{:<28} {}\n", "unknown flagged", share(result.at("unknown_flagged_percent")));
  output.print("{:<28} {}\n", "closed, median", figure(result.at("closed_median_percent"), " %"));
  output.print("{:<28} {}\n", "equation named", share(result.at("equation_named_percent")));
  output.print("{:<28} {}\n", "equation before names", share(result.at("equation_before_names_percent")));
  output.print("{:<28} {}\n\n", "calibration error", figure(result.at("calibration_error"), ""));
  output.print("{}", blind::confusion_text(result));
}

int score(const Score& options) {
  const Json result = blind::score_set(options.set, options.answers, options.detectable);
  print_score(options.output, result);
  options.output.finish(result);
  return kDone;
}

Arguments declare(Arguments& blind, Score& options) {
  Arguments arguments = blind.command("score", "Compare gap reports with the sealed labels of a set");
  arguments.option("DIR", options.set, "Folder of the set").required();
  arguments.option("--answers", options.answers, "Folder with case-0001.json and so on, plenum-gap/1 reports")
      .type_name("DIR")
      .required();
  arguments
      .option("--detectable", options.detectable,
              "An effect counts from this gap on, after recalibration, over the noise floor")
      .within(0.1, 100.0)
      .show_default();
  options.output.add_to(arguments);
  arguments.footer(
      example("  plenum blind score set --answers answers    # where answers/case-0001.json is of `plenum "
              "diagnose --json`"));
  return arguments;
}

}  // namespace

Command add_blind(Program& program) {
  struct Options {
    Generate generate;
    Score score;
  };
  Arguments arguments = program.command("blind", "Check a diagnosis on cases whose cause is withheld");
  const auto options = std::make_shared<Options>();
  const Arguments generating = declare(arguments, options->generate);
  declare(arguments, options->score);
  arguments.footer(
      example("  plenum blind generate --out set --cases 100\n"
              "  plenum blind score set --answers answers"));
  return {arguments, [options, generating] {
            return generating.given() ? generate(options->generate) : score(options->score);
          }};
}

}  // namespace plenum::host::tools
