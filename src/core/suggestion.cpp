#include "core/suggestion.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

namespace chequer {
namespace {

/// What is typed is never longer, and the work grows with its square.
constexpr std::size_t kLongest = 64;
constexpr std::size_t kLeastBeginning = 3;
constexpr std::size_t kLettersPerMistake = 3;

std::string Plain(std::string_view word) {
  std::string plain(word);
  for (char& c : plain) c = c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return plain;
}

/// Optimal string alignment distance: as Levenshtein's, with neighbours that changed places counted once.
std::size_t Mistakes(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> least(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        least[i][j] = i + j;
        continue;
      }
      const bool same = a[i - 1] == b[j - 1];
      least[i][j] = std::min({least[i - 1][j] + 1, least[i][j - 1] + 1, least[i - 1][j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        least[i][j] = std::min(least[i][j], least[i - 2][j - 2] + 1);
    }
  return least[a.size()][b.size()];
}

std::string Joined(std::span<const std::string> words) {
  std::string text;
  for (const std::string& word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text.empty() ? "none" : text;
}

}  // namespace

std::string NearestWord(std::string_view typed, std::span<const std::string> known) {
  if (typed.empty() || typed.size() > kLongest) return {};
  const std::string word = Plain(typed);
  const std::string* nearest = nullptr;
  std::size_t least = 0;
  for (const std::string& candidate : known) {
    if (candidate.size() > kLongest) continue;
    const std::string other = Plain(candidate);
    const bool begins = word.size() >= kLeastBeginning && other.starts_with(word);
    const std::size_t mistakes = begins ? std::size_t{word != other} : Mistakes(word, other);
    // A word of two letters has no mistake to spare: every other would be near.
    if (mistakes > std::max(word.size(), other.size()) / kLettersPerMistake) continue;
    if (nearest != nullptr && mistakes >= least) continue;
    nearest = &candidate;
    least = mistakes;
  }
  return nearest == nullptr ? std::string() : *nearest;
}

std::string DidYouMean(std::string_view typed, std::span<const std::string> known) {
  const std::string nearest = NearestWord(typed, known);
  return nearest.empty() ? std::string() : std::string("; did you mean '").append(nearest).append("'?");
}

std::string UnknownWord(std::string_view what, std::string_view typed, std::span<const std::string> known) {
  const std::string nearest = DidYouMean(typed, known);
  std::string text = "'";
  text.append(typed).append("' is not ").append(what).append(nearest);
  return text.append(nearest.empty() ? "; known are " : " Known are ").append(Joined(known));
}

std::vector<std::string> WordsOf(std::string_view list) {
  std::vector<std::string> words;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(", "), list.size());
    words.emplace_back(list.substr(0, end));
    list.remove_prefix(std::min(end + 2, list.size()));
  }
  return words;
}

}  // namespace chequer
