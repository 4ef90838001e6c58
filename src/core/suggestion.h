#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace chequer {

/// The known word that was probably meant, as it is written; empty where none is near. Letters' case and the
/// difference of - and _ do not count. A beginning of at least three letters is near, and so is a word within one
/// mistake for every three of its letters: a wrong, a missing, an additional letter, or two that changed places.
std::string NearestWord(std::string_view typed, std::span<const std::string> known);

/// "; did you mean 'secded'?" for the end of a message; empty where no known word is near.
std::string DidYouMean(std::string_view typed, std::span<const std::string> known);

/// What is wrong with a word that is none of those known: "'secdde' is not a variant; did you mean 'secded'? Known are
/// secded, golay". @param what such as "a variant".
std::string UnknownWord(std::string_view what, std::string_view typed, std::span<const std::string> known);

/// "a, b, c" → a, b and c, for texts that list what is known.
std::vector<std::string> WordsOf(std::string_view list);

}  // namespace chequer
