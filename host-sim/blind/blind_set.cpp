#include "host-sim/blind/blind_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "host-sim/blind/sha256.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/log_csv.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::blind {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> ids(bool catalogued) {
  std::vector<std::string> found;
  for (const DepartureKind& kind : departure_kinds()) {
    if (kind.catalogued == catalogued) found.emplace_back(kind.id);
  }
  return found;
}

/// Ten cases in a row of kind "all".
constexpr std::array<const char*, 10> kMix{"one", "one", "many",    "one", "none",
                                           "one", "one", "unknown", "one", "many"};

/// How many cases of the same kind come before this one.
std::size_t place_of(const SetRequest& request, const std::string& kind, std::size_t index) {
  if (request.kind != "all") return index;
  const auto a_row = static_cast<std::size_t>(std::count(kMix.begin(), kMix.end(), kind));
  std::size_t place = index / kMix.size() * a_row;
  for (std::size_t i = 0; i < index % kMix.size(); ++i)
    if (kMix[i] == kind) ++place;
  return place;
}

std::vector<std::string> draw_many(Random& random, const std::string& first) {
  std::vector<std::string> known = ids(true);
  std::vector<std::string> chosen;
  if (!first.empty()) {
    chosen.push_back(first);
    known.erase(std::find(known.begin(), known.end(), first));
  }
  const std::size_t wanted = random.chance(0.5) ? 2 : 3;
  while (chosen.size() < wanted) {
    const auto at = known.begin() + random.below(static_cast<unsigned>(known.size()));
    chosen.push_back(*at);
    known.erase(at);
  }
  return chosen;
}

void write_case(const SetRequest& request, std::size_t index) {
  const std::string name = case_name(index);
  const Recipe recipe = recipe_of(request, index);
  Case made = make_case(recipe);
  const auto folder = request.folder / name;
  std::filesystem::create_directories(folder);
  const std::string log = trace::format_log(made.log), heldout = trace::format_log(made.heldout),
                    rig = trace::format_rig(made.rig);
  trace::write_whole_file(folder / "log.csv", log);
  trace::write_whole_file(folder / "heldout.csv", heldout);
  trace::write_whole_file(folder / "rig.toml", rig);

  Random salt(recipe.seed, 2);
  Json label{{"schema", kLabelSchema},
             {"case", name},
             {"salt", fmt::format("{:016x}{:016x}", salt.bits(), salt.bits())}};
  label["files"] = {
      {"log.csv", sha256_hex(log)}, {"heldout.csv", sha256_hex(heldout)}, {"rig.toml", sha256_hex(rig)}};
  label.update(made.label);
  const std::string text = label.dump(2) + '\n';
  trace::write_whole_file(request.folder / "labels" / (name + ".json"), text);
  const Json open{
      {"schema", kCaseSchema}, {"case", name}, {"tier", recipe.tier}, {"label_sha256", sha256_hex(text)}};
  trace::write_whole_file(folder / "case.json", open.dump(2) + '\n');
}

}  // namespace

std::string case_name(std::size_t index) {
  return fmt::format("case-{:04}", index + 1);
}

Recipe recipe_of(const SetRequest& request, std::size_t index) {
  const std::array<std::string, 5> kinds{"one", "many", "none", "unknown", "all"};
  if (std::find(kinds.begin(), kinds.end(), request.kind) == kinds.end()) {
    throw std::invalid_argument(
        fmt::format("kind '{}' is not known, expected one of {}", request.kind, fmt::join(kinds, ", ")));
  }
  Recipe recipe;
  recipe.seconds = request.seconds;
  recipe.seed = Random(request.seed, 1000 + index).bits();
  recipe.kind = request.kind == "all" ? kMix[index % kMix.size()] : request.kind;
  if (!request.effect.empty()) {
    const bool catalogued = departure_kind(request.effect).catalogued;
    if (request.kind == "all") recipe.kind = catalogued ? "one" : "unknown";
    if (recipe.kind == "none" || catalogued == (recipe.kind == "unknown")) {
      throw std::invalid_argument(fmt::format("effect {} cannot be of kind {}, expected {}", request.effect,
                                              recipe.kind, catalogued ? "one or many" : "unknown"));
    }
  }
  const std::size_t place = request.effect.empty() ? place_of(request, recipe.kind, index) : index;
  std::size_t turn = place;  // counts once through the effects between two tiers
  Random random(recipe.seed, 3);
  if (recipe.kind == "one" || recipe.kind == "unknown") {
    const auto known = ids(recipe.kind == "one");
    recipe.effects = {request.effect.empty() ? known[place % known.size()] : request.effect};
    if (request.effect.empty()) turn = place / known.size() + place % known.size();
  } else if (recipe.kind == "many") {
    recipe.effects = draw_many(random, request.effect);
  }
  if (request.tier == "all") {
    recipe.tier = 1 + static_cast<int>(turn % 3);
  } else if (request.tier == "1" || request.tier == "2" || request.tier == "3") {
    recipe.tier = request.tier.front() - '0';
  } else {
    throw std::invalid_argument(fmt::format("tier '{}' is not known, expected 1, 2, 3 or all", request.tier));
  }
  // A third of the machines are smaller or larger than the population was drawn for.
  Random sizes(recipe.seed, 4);
  if (sizes.chance(1.0 / 3.0)) recipe.size = sizes.log_uniform(0.03, 5.0);
  return recipe;
}

void write_set(const SetRequest& request, const std::function<void(double)>& done) {
  for (std::size_t i = 0; i < request.cases; ++i) static_cast<void>(recipe_of(request, i));
  if (std::filesystem::exists(request.folder / "labels")) {
    throw trace::InputError(
        fmt::format("{}: holds a set already, expected a new folder", request.folder.string()));
  }
  std::filesystem::create_directories(request.folder / "labels");
  std::atomic<std::size_t> next{0};
  std::size_t finished = 0;
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < request.cases; i = next++) {
      try {
        write_case(request, i);
        const std::lock_guard lock(mutex);
        ++finished;
        if (done) done(static_cast<double>(finished) / static_cast<double>(request.cases));
      } catch (...) {
        const std::lock_guard lock(mutex);
        failure = std::current_exception();
        next = request.cases;
      }
    }
  };
  std::vector<std::thread> others;
  for (unsigned i = 1; i < request.threads; ++i) others.emplace_back(work);
  work();
  for (std::thread& thread : others) thread.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace plenum::host::blind
