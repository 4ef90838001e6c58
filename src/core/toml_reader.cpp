#include "core/toml_reader.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

#include "core/file.h"
#include "core/suggestion.h"
#include "core/toml_text.h"
#include "core/toml_values.h"

namespace chequer {

using namespace toml_values;

namespace {

constexpr int kMaxKeyParts = 8;

}  // namespace

struct TomlTable::Node {
  TomlFile::Impl* file = nullptr;
  const toml::table* table = nullptr;  ///< null where it is missing
  std::string path;                    ///< empty for the root
  std::set<std::string, std::less<>> asked;

  std::string FullName(std::string_view key) const {
    return Printable(path.empty() ? std::string(key) : path + "." + std::string(key));
  }
  /// The value of a key, which counts as asked for from now on; null where it is missing.
  const toml::node* Ask(std::string_view key) {
    asked.emplace(key);
    return table == nullptr ? nullptr : table->get(key);
  }
};

struct TomlFile::Impl {
  std::string name;
  toml::table document;
  std::map<std::string, TomlTable::Node> nodes;  ///< by path; a map, so that they stay where they are

  TomlTable::Node* NodeAt(const std::string& path, const toml::table* table) {
    const auto [place, is_new] = nodes.try_emplace(path);
    if (is_new) place->second = {this, table, path, {}};
    return &place->second;
  }
  std::string Place(const toml::source_region& where) const {
    if (name.empty()) return {};
    return where.begin ? name + ":" + std::to_string(where.begin.line) + ": " : name + ": ";
  }
};

std::string TomlTable::Place(std::string_view key) const {
  const toml::node* value = node_->table == nullptr ? nullptr : node_->table->get(key);
  if (value != nullptr) return node_->file->Place(value->source()) + node_->FullName(key) + " = " + Shown(*value);
  return node_->file->Place(node_->table == nullptr ? toml::source_region() : node_->table->source()) +
         node_->FullName(key);
}

std::string TomlTable::LooksLike(std::string_view key) const {
  if (node_->table == nullptr || node_->table->contains(key)) return {};
  for (const auto& [name, value] : *node_->table) {
    const std::string known(key);
    if (node_->asked.contains(name.str()) || NearestWord(name.str(), {&known, 1}).empty()) continue;
    const auto line = std::to_string(name.source().begin.line);
    return " (" + (node_->file->name.empty() ? "" : "line " + line + " has ") + "'" +
           Printable(std::string(name.str())) + "'; did you mean that?)";
  }
  return {};
}

void TomlTable::Fail(std::string_view key, std::string_view why) const {
  throw std::runtime_error(Place(key).append(": ").append(why).append(LooksLike(key)));
}

void TomlTable::FailUnknown(std::string_view key, std::string_view why) const {
  const toml::node* value = node_->table == nullptr ? nullptr : node_->table->get(key);
  const std::string place = value == nullptr ? std::string() : node_->file->Place(value->source());
  throw std::runtime_error((place + node_->FullName(key)).append(": unknown key ").append(why));
}

void TomlTable::FailMissing(std::string_view key) const { Fail(key, "is missing and has no default"); }

bool TomlTable::Has(std::string_view key) const { return node_->table != nullptr && node_->table->contains(key); }

std::map<std::string, std::string> TomlTable::Texts() const {
  std::map<std::string, std::string> texts;
  if (node_->table == nullptr) return texts;
  for (const auto& [key, value] : *node_->table) {
    std::ostringstream text;
    Print(text, value);
    texts.emplace(key.str(), text.str());
  }
  return texts;
}

bool TomlTable::Read(std::string_view key, bool& value) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = Take(*node, value);
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::Read(std::string_view key, double& value, NumberRange range) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = Take(*node, value, range);
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::Read(std::string_view key, std::int64_t& value, IntegerRange range) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = Take(*node, value, range);
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::Read(std::string_view key, int& value, IntegerRange range) {
  range.min = std::max<std::int64_t>(range.min, std::numeric_limits<int>::min());
  range.max = std::min<std::int64_t>(range.max, std::numeric_limits<int>::max());
  std::int64_t wide = 0;
  if (!Read(key, wide, range)) return false;
  value = static_cast<int>(wide);
  return true;
}

bool TomlTable::Read(std::string_view key, std::uint64_t& value, IntegerRange range) {
  range.min = std::max<std::int64_t>(range.min, 0);
  std::int64_t wide = 0;
  if (!Read(key, wide, range)) return false;
  value = static_cast<std::uint64_t>(wide);
  return true;
}

bool TomlTable::Read(std::string_view key, std::string& value, LengthRange length) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = Take(*node, value, length);
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::Read(std::string_view key, std::vector<double>& value, LengthRange length, NumberRange each) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = TakeList(*node, value, length, each);
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::Read(std::string_view key, std::vector<std::int64_t>& value, LengthRange length, IntegerRange each) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = TakeList(*node, value, length, each);
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::Read(std::string_view key, std::vector<std::string>& value, LengthRange length) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = TakeList(*node, value, length, LengthRange{1, 4096});
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::ReadLength(std::string_view key, double& value_m, NumberRange range) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = Take(*node, value_m, MetreRange{range});
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

bool TomlTable::ReadLengths(std::string_view key, std::vector<double>& values_m, LengthRange count, NumberRange each) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return false;
  const std::string wrong = TakeList(*node, values_m, count, MetreRange{each});
  if (!wrong.empty()) Fail(key, wrong);
  return true;
}

std::ptrdiff_t TomlTable::ReadWord(std::string_view key, std::span<const std::string_view> words,
                                   std::string_view or_else) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return -1;
  const auto* word = node->as_string();
  std::string allowed;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (word != nullptr && **word == words[i]) return static_cast<std::ptrdiff_t>(i);
    allowed.append(i == 0 ? "" : i + 1 == words.size() ? " or " : ", ").append("\"").append(words[i]).append("\"");
  }
  const std::vector<std::string> known(words.begin(), words.end());
  Fail(key, "must be " + allowed.append(or_else) + (word == nullptr ? std::string() : DidYouMean(**word, known)));
}

bool TomlTable::HoldsInteger(std::string_view key) const {
  const toml::node* node = node_->table == nullptr ? nullptr : node_->table->get(key);
  return node != nullptr && node->is_integer();
}

bool TomlTable::HoldsList(std::string_view key) const {
  const toml::node* node = node_->table == nullptr ? nullptr : node_->table->get(key);
  return node != nullptr && node->is_array();
}

bool TomlTable::HoldsTable(std::string_view key) const {
  const toml::node* node = node_->table == nullptr ? nullptr : node_->table->get(key);
  return node != nullptr && node->is_table();
}

std::string TomlTable::OrANumber(IntegerRange range) {
  return ", or a whole number from " + std::to_string(range.min) + " to " + std::to_string(range.max);
}

std::vector<TomlScalar> TomlTable::ReadScalars(std::size_t max_count) {
  if (node_->table == nullptr) return {};
  std::vector<std::pair<toml::source_position, TomlScalar>> found;
  for (const auto& [name, node] : *node_->table) {
    const std::string key(name.str());
    node_->asked.insert(key);
    if (found.size() == max_count) Fail(key, "there must be at most " + std::to_string(max_count) + " keys here");
    TomlScalar scalar{key, {}, Place(key)};
    if (const auto* text = node.as_string()) {
      scalar.value = text->get();
    } else if (const auto* whole = node.as_integer()) {
      scalar.value = whole->get();
    } else if (const auto* truth = node.as_boolean()) {
      scalar.value = truth->get();
    } else if (const auto* number = node.as_floating_point(); number != nullptr && std::isfinite(number->get())) {
      scalar.value = number->get();
    } else {
      Fail(key, "must be a number, a text in quotes, true or false");
    }
    found.emplace_back(name.source().begin, std::move(scalar));
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<TomlScalar> scalars;
  for (auto& [position, scalar] : found) scalars.push_back(std::move(scalar));
  return scalars;
}

TomlTable TomlTable::Table(std::string_view key) {
  const toml::node* node = node_->Ask(key);
  const std::string path = node_->FullName(key);
  if (node != nullptr && !node->is_table()) Fail(key, "must be a table, written [" + path + "]");
  return TomlTable(node_->file->NodeAt(path, node == nullptr ? nullptr : node->as_table()));
}

std::vector<TomlTable> TomlTable::Tables(std::string_view key, std::size_t max_count) {
  const toml::node* node = node_->Ask(key);
  if (node == nullptr) return {};
  const std::string path = node_->FullName(key);
  const toml::array* list = node->as_array();
  if (list == nullptr || !std::all_of(list->begin(), list->end(), [](const auto& item) { return item.is_table(); }))
    Fail(key, "must be tables, each written [[" + path + "]]");
  if (list->size() > max_count) Fail(key, "must be at most " + std::to_string(max_count) + " tables");
  std::vector<TomlTable> tables;
  for (std::size_t i = 0; i < list->size(); ++i)
    tables.push_back(TomlTable(node_->file->NodeAt(path + "[" + std::to_string(i) + "]", list->get(i)->as_table())));
  return tables;
}

TomlFile::TomlFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TomlFile::TomlFile(TomlFile&&) noexcept = default;
TomlFile& TomlFile::operator=(TomlFile&&) noexcept = default;
TomlFile::~TomlFile() = default;

TomlFile TomlFile::Load(const std::filesystem::path& path) {
  return Parse(ReadFile(path, kMaxTomlBytes), path.string());
}

TomlFile TomlFile::Parse(std::string_view text, const std::string& name) {
  if (text.size() > kMaxTomlBytes)
    throw std::runtime_error(name + ": longer than the " + std::to_string(kMaxTomlBytes) + " bytes allowed here");
  const PreparedToml prepared = PrepareToml(text, kMaxKeyParts);
  if (!prepared.wrong.empty())
    throw std::runtime_error((name.empty() ? "" : name + ":" + std::to_string(prepared.line) + ": ") + prepared.wrong);
  auto impl = std::make_unique<Impl>();
  impl->name = name;
  try {
    impl->document = toml::parse(prepared.text);
  } catch (const toml::parse_error& error) {
    throw std::runtime_error(impl->Place(error.source()) +
                             "not valid TOML: " + Printable(std::string(error.description())));
  }
  return TomlFile(std::move(impl));
}

TomlTable TomlFile::root() { return TomlTable(impl_->NodeAt("", &impl_->document)); }

void TomlFile::CheckAllKeysRead() const {
  const TomlTable::Node* owner = nullptr;
  const toml::key* unknown = nullptr;
  for (const auto& [path, node] : impl_->nodes) {
    if (node.table == nullptr) continue;
    for (const auto& [key, value] : *node.table) {
      if (node.asked.contains(key.str())) continue;
      if (unknown != nullptr && unknown->source().begin.line <= key.source().begin.line) continue;
      owner = &node;
      unknown = &key;
    }
  }
  if (unknown == nullptr) return;
  std::string known;
  for (const std::string& key : owner->asked) known.append(known.empty() ? "" : ", ").append(key);
  const std::vector<std::string> words(owner->asked.begin(), owner->asked.end());
  const std::string nearest = NearestWord(unknown->str(), words);
  throw std::runtime_error(impl_->Place(unknown->source()) + owner->FullName(unknown->str()) + ": unknown key" +
                           (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)") +
                           "; known here: " + (known.empty() ? "none" : known));
}

}  // namespace chequer
