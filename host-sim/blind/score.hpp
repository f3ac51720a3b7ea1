// How well a diagnosis did on a set of blind cases. README.md of this room defines every figure.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace plenum::host::blind {

inline constexpr double kDetectable = 1.0;  ///< recalibrated gap over the noise floor
/// A recalibrated error within this multiple of the floor counts as closed.
inline constexpr double kAtFloor = 1.15;

/// One effect of a label. Gaps in multiples of the case's noise floor.
struct TrueEffect {
  std::string id;
  bool catalogued = true;
  std::string equation;
  double gap = 0.0;
  double alone_gap = 0.0;  ///< after recalibration, this effect alone
};

struct Label {
  std::string name;
  std::string kind;  ///< one, many, none, unknown
  int tier = 1;
  double noise_floor_Pa = 0.0;
  double recalibrated_gap = 0.0;  ///< over the floor
  std::vector<TrueEffect> effects;
};

struct NamedEffect {
  std::string id;
  double confidence = 0.0;
  std::vector<std::string> aliases;
};

/// What is read of a plenum-gap/1 report.
struct Answer {
  bool given = false;  ///< false: there is no file
  std::string verdict;
  std::vector<NamedEffect> effects;
  std::vector<NamedEffect> candidates;
  std::string equation;  ///< empty: null
  double recalibrated_Pa = 0.0;
  double with_effects_Pa = 0.0;
  /// That of the likeliest disturbance, found before any cause was named: empty where none was looked for, none where reports do not
  /// have them.
  std::optional<std::string> disturbed{};
};

/// Reads and verifies the label of `set`/`name`. Throws InputError naming the file for: a label, log or rig whose
/// SHA-256 is not the one that was sealed, another schema, a field that is missing or of another type.
Label read_label(const std::filesystem::path& set, const std::string& name);

/// Throws InputError naming file and field; a file that is not there is an Answer that is not given.
Answer read_answer(const std::filesystem::path& file);

/// `case-*` folders of a set, in order. Throws InputError when there is none.
std::vector<std::string> case_names(const std::filesystem::path& set);

/// The figures, as schema plenum-blind-score/1. A share over no cases is null.
nlohmann::ordered_json score(const std::vector<Label>& labels, const std::vector<Answer>& answers,
                             double detectable = kDetectable);

/// As score(), from the folders.
nlohmann::ordered_json score_set(const std::filesystem::path& set, const std::filesystem::path& answers,
                                 double detectable = kDetectable);

/// The confusion matrix as text: a line a truth, a column an answer.
std::string confusion_text(const nlohmann::ordered_json& score);

}  // namespace plenum::host::blind
