#pragma once

namespace chequer {

/// What one run of a stage works with: nothing that one run leaves reaches the next. Start() makes the whole state as a
/// new one, so that no member can be forgotten.
/// The memory stays: where an empty vector is copied onto another one, that keeps what it has. So a state has vectors
/// of plain values (with vectors inside them, those would be allocated anew), FixedVector and RawBuffer.
/// What a stage keeps on purpose is no Scratch: it is const, or a member whose comment says why it may be kept.
template <class State>
class Scratch {
 public:
  /// To be called at the beginning of every run.
  State& Start() {
    static const State kNew{};
    state_ = kNew;
    return state_;
  }

  State* operator->() { return &state_; }
  const State* operator->() const { return &state_; }
  State& operator*() { return state_; }
  const State& operator*() const { return state_; }

 private:
  State state_;
};

}  // namespace chequer
