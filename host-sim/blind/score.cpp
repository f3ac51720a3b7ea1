#include "host-sim/blind/score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "host-sim/blind/blind_set.hpp"
#include "host-sim/blind/sha256.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::blind {
namespace {

using Json = nlohmann::ordered_json;
using trace::InputError;

// ---- reading

Json parse(const std::string& text, const std::string& file) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw InputError(fmt::format("{}: not JSON at byte {}, expected an object", file, error.byte));
  } catch (const Json::out_of_range&) {
    throw InputError(fmt::format("{}: a number is too large, expected numbers of double precision", file));
  }
}

/// Field `key` of an object; `expected` says what it must be.
template <class Is>
const Json& field(const Json& object, const char* key, Is is, const char* expected, const std::string& file) {
  if (!object.is_object() || !object.contains(key)) {
    throw InputError(fmt::format("{}: {} is missing, expected {}", file, key, expected));
  }
  const Json& value = object.at(key);
  if (!is(value))
    throw InputError(fmt::format("{}: {} is {}, expected {}", file, key, value.dump(), expected));
  return value;
}

double number_in(const Json& object, const char* key, const std::string& file) {
  return field(
             object, key, [](const Json& v) { return v.is_number(); }, "a number", file)
      .get<double>();
}

std::string text_in(const Json& object, const char* key, const std::string& file) {
  return field(
             object, key, [](const Json& v) { return v.is_string(); }, "a text", file)
      .get<std::string>();
}

const Json& list_in(const Json& object, const char* key, const std::string& file) {
  return field(
      object, key, [](const Json& v) { return v.is_array(); }, "a list", file);
}

const Json& object_in(const Json& object, const char* key, const std::string& file) {
  return field(
      object, key, [](const Json& v) { return v.is_object(); }, "an object", file);
}

void require_schema(const Json& object, const char* schema, const std::string& file) {
  const std::string found = text_in(object, "schema", file);
  if (found != schema) throw InputError(fmt::format("{}: schema is {}, expected {}", file, found, schema));
}

void require_digest(const std::string& bytes, const std::string& sealed, const std::string& file) {
  if (sha256_hex(bytes) != sealed) {
    throw InputError(fmt::format("{}: SHA-256 {}, expected the sealed {}: the file was changed", file,
                                 sha256_hex(bytes), sealed));
  }
}

NamedEffect named(const Json& entry, const std::string& file) {
  NamedEffect effect{text_in(entry, "id", file), number_in(entry, "confidence", file), {}};
  if (effect.confidence < 0.0 || effect.confidence > 1.0) {
    throw InputError(
        fmt::format("{}: confidence of {} is {}, expected 0 to 1", file, effect.id, effect.confidence));
  }
  if (entry.contains("aliases")) {
    for (const Json& alias : list_in(entry, "aliases", file)) {
      if (!alias.is_string()) throw InputError(fmt::format("{}: an alias of {} is no text", file, effect.id));
      effect.aliases.push_back(alias.get<std::string>());
    }
  }
  return effect;
}

constexpr std::array<const char*, 6> kVerdicts{"none",      "calibration", "explained", "partly_explained",
                                               "ambiguous", "unexplained"};

// ---- counting

/// A share of cases.
struct Share {
  unsigned right = 0;
  unsigned of = 0;

  void count(bool is_right) {
    right += is_right ? 1U : 0U;
    ++of;
  }
  Json percent() const { return of == 0 ? Json(nullptr) : Json(100.0 * right / of); }
  Json json() const { return {{"percent", percent()}, {"right", right}, {"of", of}}; }
};

bool calm(const Answer& answer) {
  return answer.verdict == "none" || answer.verdict == "calibration";
}

/// All that the answer says may be present: effects with their aliases.
bool in_set(const Answer& answer, const std::string& id) {
  return std::any_of(answer.effects.begin(), answer.effects.end(), [&](const NamedEffect& effect) {
    return effect.id == id ||
           std::find(effect.aliases.begin(), effect.aliases.end(), id) != effect.aliases.end();
  });
}

bool is_true(const Label& label, const std::string& id) {
  return std::any_of(label.effects.begin(), label.effects.end(),
                     [&](const TrueEffect& effect) { return effect.id == id; });
}

std::string first_name(const Answer& answer) {
  if (!answer.given) return "no answer";
  if (calm(answer)) return "none";
  if (answer.effects.empty()) return "unexplained";
  return answer.effects.front().id;
}

enum class Class { kDetectable, kAbsorbed, kSmall };

/// Whether a recording can show the effect at all, decided from the label alone.
Class class_of(double gap, double recalibrated_gap, double detectable) {
  if (recalibrated_gap >= detectable) return Class::kDetectable;
  const bool closed = std::sqrt(recalibrated_gap * recalibrated_gap + 1.0) <= kAtFloor;
  return gap >= detectable && closed ? Class::kAbsorbed : Class::kSmall;
}

/// Expected calibration error over ten bins of equal width.
struct Calibration {
  struct Bin {
    double confidence = 0.0;
    unsigned right = 0;
    unsigned of = 0;
  };
  std::array<Bin, 10> bins{};

  void count(double confidence, bool right) {
    auto& bin = bins[std::min<std::size_t>(static_cast<std::size_t>(confidence * 10.0), 9)];
    bin.confidence += confidence;
    bin.right += right ? 1U : 0U;
    ++bin.of;
  }
  Json error() const {
    double sum = 0.0;
    unsigned all = 0;
    for (const Bin& bin : bins) {
      sum += std::abs(bin.confidence - bin.right);
      all += bin.of;
    }
    return all == 0 ? Json(nullptr) : Json(sum / all);
  }
  Json table() const {
    Json rows = Json::array();
    for (std::size_t i = 0; i < bins.size(); ++i) {
      const Bin& bin = bins[i];
      if (bin.of == 0) continue;
      rows.push_back({{"from", 0.1 * static_cast<double>(i)},
                      {"named", bin.of},
                      {"mean_confidence", bin.confidence / bin.of},
                      {"right", bin.right / static_cast<double>(bin.of)}});
    }
    return rows;
  }
};

Json median(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

class Scorer {
 public:
  explicit Scorer(double detectable) : detectable_(detectable) {}

  void add(const Label& label, const Answer& answer) {
    ++cases_;
    if (!answer.given) ++missing_;
    add_confidences(label, answer);
    if (label.kind == "one") add_one(label, answer);
    if (label.kind == "many") add_many(label, answer);
    if (label.kind == "none") add_none(label, answer);
    if (label.kind == "unknown") add_unknown(label, answer);
  }

  Json result() const {
    const unsigned recalled = hits_ + misses_, named = hits_ + false_names_;
    const double both = recalled + named;
    Json out{{"schema", "plenum-blind-score/1"},
             {"cases", cases_},
             {"missing_answers", missing_},
             {"detectable_over_floor", detectable_},
             {"counts", counts_}};
    Share all;
    Json by_tier = Json::object();
    for (const auto& [tier, share] : top1_) {
      by_tier[fmt::format("tier{}", tier)] = share.json();
      all.right += share.right;
      all.of += share.of;
    }
    by_tier["all"] = all.json();
    out["top1_percent"] = by_tier;
    out["singleton_correct_percent"] = singleton_.json();
    out["coverage_percent"] = coverage_.json();
    out["multi_f1"] = {{"f1", both == 0.0 ? Json(nullptr) : Json(2.0 * hits_ / both)},
                       {"hits", hits_},
                       {"false_names", false_names_},
                       {"misses", misses_}};
    out["false_alarm_percent"] = false_alarm_.json();
    out["unknown_flagged_percent"] = unknown_.json();
    out["closed_median_percent"] = median(closed_percent_);
    out["equation_named_percent"] = equation_.json();
    out["equation_before_names_percent"] = disturbed_.json();
    out["calibration_error"] = effects_.error();
    out["calibration_error_candidates"] = candidates_.error();
    out["reliability"] = effects_.table();
    out["confusion"] = confusion();
    out["mistakes"] = mistakes_;
    return out;
  }

 private:
  void add_confidences(const Label& label, const Answer& answer) {
    for (const NamedEffect& effect : answer.effects)
      effects_.count(effect.confidence, is_true(label, effect.id));
    for (const NamedEffect& one : answer.candidates)
      candidates_.count(one.confidence, is_true(label, one.id));
  }

  void count(const std::string& what) { counts_[what] = counts_.value(what, 0U) + 1U; }

  void add_one(const Label& label, const Answer& answer) {
    const TrueEffect& truth = label.effects.front();
    if ((answer.verdict == "explained" || answer.verdict == "partly_explained") &&
        answer.effects.size() == 1 && answer.effects.front().aliases.empty()) {
      const bool right = answer.effects.front().id == truth.id;
      singleton_.count(right);
      if (!right) mistake(label, answer, "one name, wrong");
    }
    const Class kind = class_of(truth.gap, label.recalibrated_gap, detectable_);
    if (kind == Class::kAbsorbed) {
      count("one_absorbed");
      if (calm(answer)) count("one_absorbed_answered_calm");
      return;
    }
    if (kind == Class::kSmall) {
      count("one_small");
      return;
    }
    count("one_detectable");
    ++confusion_[truth.id][answer.verdict == "ambiguous" && in_set(answer, truth.id)
                               ? "ambiguous, truth in it"
                               : first_name(answer)];
    const bool covered = answer.given && in_set(answer, truth.id);
    coverage_.count(covered);
    const bool right =
        answer.given && !answer.effects.empty() && answer.effects.front().id == truth.id && !calm(answer);
    if (answer.verdict == "ambiguous" && covered) {
      count("one_ambiguous_with_truth");
    } else {
      top1_[label.tier].count(right);
      if (!right) mistake(label, answer, "first name");
    }
    const bool equation_right = answer.equation == truth.equation;
    equation_.count(equation_right);
    if (!equation_right) mistake(label, answer, "equation");
    if (answer.disturbed) disturbed_.count(*answer.disturbed == truth.equation);
    add_closed(label, answer);
  }

  void add_many(const Label& label, const Answer& answer) {
    if (label.recalibrated_gap < detectable_) {
      count("many_small_or_absorbed");
      return;
    }
    count("many_detectable");
    bool exact = true;
    for (const TrueEffect& truth : label.effects) {
      if (truth.alone_gap < detectable_) continue;
      const bool hit = !calm(answer) && std::any_of(answer.effects.begin(), answer.effects.end(),
                                                    [&](const NamedEffect& e) { return e.id == truth.id; });
      ++(hit ? hits_ : misses_);
      exact &= hit;
    }
    for (const NamedEffect& effect : answer.effects) {
      if (is_true(label, effect.id)) continue;  // a true one that is too small is neither hit nor false
      ++false_names_;
      exact = false;
    }
    if (!exact) mistake(label, answer, "set");
    add_closed(label, answer);
  }

  void add_none(const Label& label, const Answer& answer) {
    count("none");
    const bool alarm = !answer.given || !calm(answer);
    false_alarm_.count(alarm);
    if (alarm) mistake(label, answer, "false alarm");
    ++confusion_["none"][first_name(answer)];
  }

  void add_unknown(const Label& label, const Answer& answer) {
    const TrueEffect& truth = label.effects.front();
    if (label.recalibrated_gap < detectable_) {
      count("unknown_small_or_absorbed");
      return;
    }
    ++confusion_[truth.id][first_name(answer)];
    if ((answer.verdict == "explained" || answer.verdict == "ambiguous") &&
        answer.with_effects_Pa <= kAtFloor * label.noise_floor_Pa) {
      count("unknown_fitted_by_the_catalogue");
      return;
    }
    count("unknown_detectable");
    const bool flagged = answer.verdict == "unexplained" || answer.verdict == "partly_explained";
    unknown_.count(flagged);
    if (!flagged) mistake(label, answer, "unknown not flagged");
  }

  /// What was closed of what was closable, the floor being the label's.
  void add_closed(const Label& label, const Answer& answer) {
    if (!answer.given) {
      closed_percent_.push_back(0.0);
      return;
    }
    const double closable = answer.recalibrated_Pa - label.noise_floor_Pa;
    if (closable <= 0.0) return;
    const double closed = (answer.recalibrated_Pa - answer.with_effects_Pa) / closable;
    closed_percent_.push_back(100.0 * std::clamp(closed, 0.0, 1.0));
  }

  void mistake(const Label& label, const Answer& answer, const char* what) {
    Json truth = Json::array(), said = Json::array();
    for (const TrueEffect& effect : label.effects) {
      truth.push_back(
          {{"id", effect.id}, {"gap_over_floor", effect.gap}, {"alone_over_floor", effect.alone_gap}});
    }
    for (const NamedEffect& effect : answer.effects) {
      said.push_back({{"id", effect.id}, {"confidence", effect.confidence}, {"aliases", effect.aliases}});
    }
    mistakes_.push_back({{"case", label.name},
                         {"what", what},
                         {"tier", label.tier},
                         {"truth", truth},
                         {"recalibrated_over_floor", label.recalibrated_gap},
                         {"verdict", answer.given ? answer.verdict : "no answer"},
                         {"effects", said},
                         {"equation", answer.equation}});
  }

  Json confusion() const {
    std::vector<std::string> rows, columns;
    for (const DepartureKind& kind : departure_kinds()) {
      rows.emplace_back(kind.id);
      if (kind.catalogued) columns.emplace_back(kind.id);
    }
    rows.emplace_back("none");
    for (const char* column : {"none", "ambiguous, truth in it", "unexplained", "no answer"})
      columns.emplace_back(column);
    for (const auto& [truth, line] : confusion_) {  // ids that this room does not know
      for (const auto& [said, n] : line) {
        if (std::find(columns.begin(), columns.end(), said) == columns.end()) columns.push_back(said);
      }
    }
    Json counts = Json::array();
    std::vector<std::string> kept;
    for (const std::string& row : rows) {
      const auto line = confusion_.find(row);
      if (line == confusion_.end()) continue;
      kept.push_back(row);
      Json cells = Json::array();
      for (const std::string& column : columns) {
        const auto cell = line->second.find(column);
        cells.push_back(cell == line->second.end() ? 0U : cell->second);
      }
      counts.push_back(std::move(cells));
    }
    return {{"truth", kept}, {"answer", columns}, {"counts", counts}};
  }

  double detectable_;
  unsigned cases_ = 0, missing_ = 0;
  Json counts_ = Json::object();
  std::map<int, Share> top1_;
  Share singleton_, coverage_, false_alarm_, unknown_, equation_, disturbed_;
  unsigned hits_ = 0, misses_ = 0, false_names_ = 0;
  std::vector<double> closed_percent_;
  Calibration effects_, candidates_;
  std::map<std::string, std::map<std::string, unsigned>> confusion_;
  Json mistakes_ = Json::array();
};

}  // namespace

Label read_label(const std::filesystem::path& set, const std::string& name) {
  const std::string open_file = (set / name / "case.json").string();
  const Json open = parse(trace::read_whole_file(open_file), open_file);
  require_schema(open, kCaseSchema, open_file);
  const std::string file = (set / "labels" / (name + ".json")).string();
  const std::string text = trace::read_whole_file(file);
  require_digest(text, text_in(open, "label_sha256", open_file), file);
  const Json label = parse(text, file);
  require_schema(label, kLabelSchema, file);
  const Json& digests = object_in(label, "files", file);
  for (const char* data : {"log.csv", "heldout.csv", "rig.toml"}) {
    const auto path = set / name / data;
    require_digest(trace::read_whole_file(path), text_in(digests, data, file), path.string());
  }

  Label out;
  out.name = name;
  out.kind = text_in(label, "kind", file);
  out.tier = static_cast<int>(number_in(label, "tier", file));
  out.noise_floor_Pa = number_in(label, "noise_floor_Pa", file);
  if (!(out.noise_floor_Pa > 0.0)) {
    throw InputError(
        fmt::format("{}: noise_floor_Pa is {}, expected a positive one", file, out.noise_floor_Pa));
  }
  out.recalibrated_gap = number_in(label, "recalibrated_gap_Pa", file) / out.noise_floor_Pa;
  for (const Json& entry : list_in(label, "effects", file)) {
    TrueEffect effect;
    effect.id = text_in(entry, "id", file);
    effect.equation = text_in(entry, "equation", file);
    effect.gap = number_in(entry, "gap_Pa", file) / out.noise_floor_Pa;
    effect.alone_gap = number_in(entry, "alone_recalibrated_gap_Pa", file) / out.noise_floor_Pa;
    effect.catalogued = departure_kind(effect.id).catalogued;
    out.effects.push_back(std::move(effect));
  }
  if (out.effects.empty() != (out.kind == "none")) {
    throw InputError(
        fmt::format("{}: {} effects, expected those of kind {}", file, out.effects.size(), out.kind));
  }
  return out;
}

Answer read_answer(const std::filesystem::path& path) {
  Answer answer;
  if (!std::filesystem::exists(path)) return answer;
  const std::string file = path.string();
  const Json report = parse(trace::read_whole_file(path), file);
  require_schema(report, "plenum-gap/1", file);
  answer.given = true;
  answer.verdict = text_in(report, "verdict", file);
  if (std::find(kVerdicts.begin(), kVerdicts.end(), answer.verdict) == kVerdicts.end()) {
    throw InputError(fmt::format("{}: verdict is {}, expected one of {}", file, answer.verdict,
                                 fmt::join(kVerdicts, ", ")));
  }
  for (const Json& entry : list_in(report, "effects", file)) answer.effects.push_back(named(entry, file));
  for (const Json& entry : list_in(report, "candidates", file))
    answer.candidates.push_back(named(entry, file));
  if (report.contains("equation") && report.at("equation").is_object()) {
    const Json& id = report.at("equation");
    if (id.contains("id") && id.at("id").is_string()) answer.equation = id.at("id").get<std::string>();
  }
  if (report.contains("disturbances")) {
    const Json& all = list_in(report, "disturbances", file);
    answer.disturbed = all.empty() ? std::string() : text_in(all.front(), "equation", file);
  }
  const Json& gap = object_in(report, "gap_kPa", file);
  answer.recalibrated_Pa = 1e3 * number_in(gap, "recalibrated", file);
  answer.with_effects_Pa = 1e3 * number_in(gap, "with_effects", file);
  return answer;
}

std::vector<std::string> case_names(const std::filesystem::path& set) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(set, error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("case-", 0) == 0) names.push_back(name);
  }
  if (names.empty()) {
    throw InputError(fmt::format("{}: no case in it, expected the folder of a blind set", set.string()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

Json score(const std::vector<Label>& labels, const std::vector<Answer>& answers, double detectable) {
  Scorer scorer(detectable);
  for (std::size_t i = 0; i < labels.size(); ++i) scorer.add(labels[i], answers[i]);
  return scorer.result();
}

Json score_set(const std::filesystem::path& set, const std::filesystem::path& answers, double detectable) {
  if (!std::filesystem::is_directory(answers)) {
    throw InputError(fmt::format("{}: no such folder, expected one of gap reports", answers.string()));
  }
  std::vector<Label> labels;
  std::vector<Answer> given;
  for (const std::string& name : case_names(set)) {
    labels.push_back(read_label(set, name));
    given.push_back(read_answer(answers / (name + ".json")));
  }
  if (std::none_of(given.begin(), given.end(), [](const Answer& answer) { return answer.given; })) {
    throw InputError(fmt::format("{}: no answer in it, expected {}.json and so on", answers.string(),
                                 labels.front().name));
  }
  return score(labels, given, detectable);
}

std::string confusion_text(const Json& score) {
  const Json& table = score.at("confusion");
  const auto& truths = table.at("truth");
  const auto& said = table.at("answer");
  std::vector<std::size_t> columns;  // those that were answered at all
  for (std::size_t c = 0; c < said.size(); ++c) {
    const bool used = std::any_of(table.at("counts").begin(), table.at("counts").end(),
                                  [c](const Json& line) { return line.at(c).get<unsigned>() > 0; });
    if (used) columns.push_back(c);
  }
  std::string text = fmt::format("{:<22}", "truth \\ first answer");
  for (std::size_t i = 0; i < columns.size(); ++i) text += fmt::format(" {:>3}", static_cast<char>('A' + i));
  text += '\n';
  for (std::size_t r = 0; r < truths.size(); ++r) {
    text += fmt::format("{:<22}", truths.at(r).get<std::string>());
    for (const std::size_t c : columns) {
      const auto n = table.at("counts").at(r).at(c).get<unsigned>();
      text += n == 0 ? "   ." : fmt::format(" {:>3}", n);
    }
    text += '\n';
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", static_cast<char>('A' + i),
                        said.at(columns[i]).get<std::string>());
  }
  return text + '\n';
}

}  // namespace plenum::host::blind
