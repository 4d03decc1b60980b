// Box<T>: a T on the heap that behaves like a value (deep copy, never empty unless moved from).
// It lets the nodes of the syntax tree contain each other.
#pragma once

#include <memory>
#include <utility>

namespace hvi::lang {

template <class T>
class Box {
public:
  Box() : value_(std::make_unique<T>()) {}
  Box(T value) : value_(std::make_unique<T>(std::move(value))) {} // implicit: Box is a T
  Box(const Box& other) : value_(std::make_unique<T>(*other.value_)) {}
  Box(Box&&) noexcept = default;
  Box& operator=(const Box& other) {
    value_ = std::make_unique<T>(*other.value_);
    return *this;
  }
  Box& operator=(Box&&) noexcept = default;
  ~Box() = default;

  T& operator*() { return *value_; }
  const T& operator*() const { return *value_; }
  T* operator->() { return value_.get(); }
  const T* operator->() const { return value_.get(); }

private:
  std::unique_ptr<T> value_;
};

} // namespace hvi::lang
