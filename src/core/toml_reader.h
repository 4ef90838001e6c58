#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace chequer {

/// The largest TOML file that is read.
inline constexpr std::size_t kMaxTomlBytes = 1u << 20;

/// Values that are allowed, both ends included.
struct NumberRange {
  double min = 0;
  double max = 0;
};
struct IntegerRange {
  std::int64_t min = 0;
  std::int64_t max = 0;
};
/// Characters of a text, or elements of a list, both ends included.
struct LengthRange {
  std::size_t min = 0;
  std::size_t max = 4096;
};

/// A single value of any type.
struct TomlScalar {
  std::string key;
  std::variant<bool, std::int64_t, double, std::string> value;
  std::string place;  ///< TomlTable::Place
};

/// A table of a TomlFile, borrowed: the file must outlive it. Each key must be asked for: what nobody asked for is
/// refused by TomlFile::CheckAllKeysRead.
///
/// Each Read leaves `value` alone and returns false where the key is not there; throws std::runtime_error where the
/// value is of another type or out of range, as "swarm.toml:12: capture.fps = -3: must be from 0.1 to 1000".
class TomlTable {
 public:
  bool Read(std::string_view key, bool& value);
  /// A whole or a decimal number; nan and inf are refused.
  bool Read(std::string_view key, double& value, NumberRange range);
  bool Read(std::string_view key, int& value, IntegerRange range);
  bool Read(std::string_view key, std::int64_t& value, IntegerRange range);
  bool Read(std::string_view key, std::uint64_t& value, IntegerRange range);
  bool Read(std::string_view key, std::string& value, LengthRange length = {1, 4096});
  bool Read(std::string_view key, std::vector<double>& value, LengthRange length, NumberRange each);
  bool Read(std::string_view key, std::vector<std::int64_t>& value, LengthRange length, IntegerRange each);
  bool Read(std::string_view key, std::vector<std::string>& value, LengthRange length);

  /// A length in metres: a number, or a text with its unit such as "60mm". @param range metres.
  bool ReadLength(std::string_view key, double& value_m, NumberRange range);
  /// A list of them. @param count how many; @param each metres.
  bool ReadLengths(std::string_view key, std::vector<double>& values_m, LengthRange count, NumberRange each);

  /// Whatever keys the table has, in the order in which they are written. Throws where one is neither a text, a number
  /// nor true or false.
  std::vector<TomlScalar> ReadScalars(std::size_t max_count);

  /// One of some words. @param choices word and value, all words named in the message. @param or_else what else the
  /// message says is allowed.
  template <typename Enum, std::size_t count>
  bool Read(std::string_view key, Enum& value, const std::array<std::pair<std::string_view, Enum>, count>& choices,
            std::string_view or_else = {}) {
    std::array<std::string_view, count> words;
    for (std::size_t i = 0; i < count; ++i) words[i] = choices[i].first;
    const std::ptrdiff_t index = ReadWord(key, words, or_else);
    if (index < 0) return false;
    value = choices[static_cast<std::size_t>(index)].second;
    return true;
  }

  /// One of some words, or a whole number: then `value` becomes `numbered`.
  template <typename Enum, std::size_t count>
  bool Read(std::string_view key, Enum& value, const std::array<std::pair<std::string_view, Enum>, count>& choices,
            Enum numbered, std::uint64_t& number, IntegerRange range) {
    if (!HoldsInteger(key)) return Read(key, value, choices, OrANumber(range));
    value = numbered;
    return Read(key, number, range);
  }

  /// As Read, but throws where the key is missing.
  template <typename Value, typename... Limits>
  void Require(std::string_view key, Value& value, const Limits&... limits) {
    if (!Read(key, value, limits...)) FailMissing(key);
  }

  /// Whether the key is there. Does not count as asking for it.
  bool Has(std::string_view key) const;

  /// Whether the key holds a list, or a table. Does not count as asking for it.
  bool HoldsList(std::string_view key) const;
  bool HoldsTable(std::string_view key) const;

  /// The table of that name; an empty one where it is missing.
  TomlTable Table(std::string_view key);
  /// The tables of that name ([[key]]), in order; none where it is missing.
  std::vector<TomlTable> Tables(std::string_view key, std::size_t max_count);

  /// What each key says, printed so that equal texts mean the same: without comments, spacing and order. Does not count
  /// as asking for them.
  std::map<std::string, std::string> Texts() const;

  /// What stands in front of messages about a key: "swarm.toml:12: capture.fps = -3"; of a key that is missing, the
  /// table's place and the key.
  std::string Place(std::string_view key) const;

  /// Throws with place, key and value in front: "swarm.toml:12: capture.fps = -3: why". Where the key is missing, the
  /// table's place is named, and a key that nobody asked for and that looks like it.
  [[noreturn]] void Fail(std::string_view key, std::string_view why) const;
  [[noreturn]] void FailMissing(std::string_view key) const;
  /// Of a key that is known, but not here: "swarm.toml:12: capture.loop: unknown key why".
  [[noreturn]] void FailUnknown(std::string_view key, std::string_view why) const;

 private:
  friend class TomlFile;
  struct Node;
  explicit TomlTable(Node* node) : node_(node) {}

  /// " (line 7 has 'postion'; did you mean that?)", or nothing.
  std::string LooksLike(std::string_view key) const;

  /// The index of the word; −1 where the key is missing.
  std::ptrdiff_t ReadWord(std::string_view key, std::span<const std::string_view> words, std::string_view or_else);
  bool HoldsInteger(std::string_view key) const;
  static std::string OrANumber(IntegerRange range);

  Node* node_;  ///< owned by the file
};

/// A TOML document and which of its keys were asked for.
class TomlFile {
 public:
  /// Throws std::runtime_error naming the file, and the line where there is one, if it cannot be read, is longer than
  /// kMaxTomlBytes, or is not TOML.
  static TomlFile Load(const std::filesystem::path& path);
  /// The same from a text. @param name stands for the file in messages; empty: they begin with the key, as there is no
  /// file whose lines anybody could look at.
  static TomlFile Parse(std::string_view text, const std::string& name);

  TomlFile(TomlFile&&) noexcept;
  TomlFile& operator=(TomlFile&&) noexcept;
  ~TomlFile();

  TomlTable root();

  /// Throws std::runtime_error naming the first key that nobody asked for, those of its table that were, and the one of
  /// them that was probably meant.
  void CheckAllKeysRead() const;

 private:
  friend class TomlTable;
  struct Impl;
  explicit TomlFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
