#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <utility>

namespace chequer {

/// A map that holds at most so many entries: a new one takes the place of the one that was not asked for the longest.
/// What comes from the network goes into such a one, as there may be any number of it.
template <typename Key, typename Value>
class RecentMap {
 public:
  /// @pre capacity > 0.
  explicit RecentMap(std::size_t capacity) : capacity_(capacity) {}

  /// The value of a key, a new one where there is none.
  Value& operator[](const Key& key) {
    auto found = entries_.find(key);
    if (found == entries_.end()) {
      if (entries_.size() == capacity_) Erase(entries_.find(*by_age_.front()));
      found = entries_.try_emplace(key).first;
      by_age_.push_back(&found->first);
      found->second.place = std::prev(by_age_.end());
    } else {
      by_age_.splice(by_age_.end(), by_age_, found->second.place);
    }
    return found->second.value;
  }

  /// @param is_old of a value.
  template <typename Predicate>
  void EraseIf(const Predicate& is_old) {
    for (auto entry = entries_.begin(); entry != entries_.end();)
      entry = is_old(entry->second.value) ? Erase(entry) : std::next(entry);
  }

  /// Calls with key and value, by key. @param visit gives false where it has had enough.
  template <typename Visit>
  void ForEach(const Visit& visit) const {
    for (const auto& [key, entry] : entries_)
      if (!visit(key, entry.value)) return;
  }

  std::size_t size() const { return entries_.size(); }
  bool empty() const { return entries_.empty(); }

 private:
  using Ages = std::list<const Key*>;  ///< map entries stay where they are
  struct Entry {
    Value value{};
    typename Ages::iterator place{};
  };
  using Entries = std::map<Key, Entry>;

  typename Entries::iterator Erase(typename Entries::iterator entry) {
    by_age_.erase(entry->second.place);
    return entries_.erase(entry);
  }

  std::size_t capacity_;
  Entries entries_;
  Ages by_age_;  ///< the oldest first
};

}  // namespace chequer
