// A rig of bodies in the number type of the computation, and the room its pieces are expanded in.
#pragma once

#include "stickslip/bodies/dense.hpp"
#include "stickslip/bodies/run_tape.hpp"

namespace stickslip::inline STICKSLIP_ISA {

constexpr int slips_minus = -1, sticks = 0, slips_plus = 1;

template <class T>
struct Contact {
  Tape<T> tape[2];  // v < 0, v > 0
  int states = 0, first_state = 0, speed = -1;
  bool compliant[2] = {};
  signed char mode = 0;
  // of a mode in slip whose force is linear in u: T = level + slope (d . q' - V)
  bool linear = false;
  T level, slope;
  Interval<T> interval;  // of u, in which no linear surface changes its side
  bool leaving = false;  // it slips off from rest: u is 0 at the start of the piece
  bool tried = false;    // let go by the rule at this transition
  T since;               // time from which the dwell counts
};

template <class T>
struct Rail {  // a prescribed speed
  Tape<T>* piece;
  int now = 0;
  bool steady = true, filled = false;  // constant at present; its series stands
  bool linear = true;                  // linear in t at present
};

template <class T>
struct BodiesSystem {
  const Bodies* b = nullptr;
  BodiesLayout at{};
  int n = 0, contacts = 0, speeds = 0, states = 0, columns = 0;
  T* values = nullptr;
  T* inverse = nullptr;       // of M
  T* reach = nullptr;         // M^-1 d_j (contacts x n)
  Real<T>* weight = nullptr;  // root of the inertia of each coordinate
  T* free = nullptr;          // q'' of the free rig by (q, q', 1, x, V, -T): n x columns
  T* projected = nullptr;     // the same with what sticks held
  T* held = nullptr;          // friction of what sticks by the same (contacts x columns)
  T* yields = nullptr;        // M^-1 D' G^-1: what an acceleration of the stuck adds (n x contacts)
  T *compliance = nullptr, *stiff = nullptr, *room = nullptr;  // G = D M^-1 D', its inverse
  int* stuck = nullptr;
  int stuck_count = 0;
  int surface_order = max_order;  // of surfaces where a formula goes over continuously
  Real<T> rate{}, frequency{};    // bounds on the eigenvalues of the present modes, and of the springs
  bool pulled = false;            // some force follows a prescribed motion
  Contact<T>* contact = nullptr;
  Rail<T>* rail = nullptr;
  // the series of a piece
  T *q = nullptr, *v = nullptr, *z = nullptr, *x = nullptr, *V = nullptr;
  T *u = nullptr, *force = nullptr, *friction = nullptr, *margin = nullptr, *dwell = nullptr, *time = nullptr;
  const T** states_of = nullptr;
  int ids = 0;  // of switching functions: 2 a contact, one a node of every tape

  T* D(int j) const { return values + at.D + j * n; }
  static T* row(T* all, int i) { return all + i * series_size; }

  void place(Arena& arena, const Bodies& bodies, const double* numbers) {
    b = &bodies;
    at = layout_of(bodies);
    n = bodies.n, contacts = bodies.contacts, speeds = bodies.speeds, states = bodies.states;
    columns = 2 * n + 1 + 2 * speeds + contacts;
    values = arena.take<T>(at.size);
    inverse = arena.take<T>(n * n);
    reach = arena.take<T>(contacts * n);
    weight = arena.take<Real<T>>(n);
    free = arena.take<T>(n * columns);
    projected = arena.take<T>(n * columns);
    held = arena.take<T>(contacts * columns);
    yields = arena.take<T>(n * contacts);
    compliance = arena.take<T>(contacts * contacts);
    stiff = arena.take<T>(contacts * contacts);
    room = arena.take<T>(n * n + contacts * columns);
    stuck = arena.take<int>(contacts);
    for (T** one : {&q, &v}) *one = arena.take<T>(n * series_size);
    z = arena.take<T>(states * series_size);
    for (T** one : {&x, &V}) *one = arena.take<T>(speeds * series_size);
    for (T** one : {&u, &force, &friction, &dwell}) *one = arena.take<T>(contacts * series_size);
    margin = arena.take<T>(2 * contacts * series_size);
    time = arena.take<T>(series_size);
    states_of = arena.take<const T*>(states);
    contact = arena.take<Contact<T>>(contacts);
    rail = arena.take<Rail<T>>(speeds);
    place_tapes(arena, numbers + at.parameters);
  }

 private:
  void place_tapes(Arena& arena, const double* parameters) {
    const bool real = arena.base != nullptr;
    int first = 0;
    ids = 2 * contacts;
    Contact<T> scratch{};
    for (int j = 0; j < contacts; ++j) {
      Contact<T>& one = real ? contact[j] : scratch;
      one = Contact<T>{};
      const LawTape& law = b->laws[j];
      one.states = law.states;
      one.first_state = first;
      one.speed = b->contact_speed[j];
      for (int s = 0; s < 2; ++s) {
        one.compliant[s] = law.branch[s].limit < 0;
        one.tape[s].place(arena, law.branch[s], parameters);
        one.tape[s].reads = {values + at.parameters, row(u, j), time, row(dwell, j), states_of + first, 0.0, false};
        one.tape[s].first_id = ids;
        ids += law.branch[s].count;
      }
      if (real)
        for (int i = 0; i < law.states; ++i) states_of[first + i] = row(z, first + i);
      first += law.states;
    }
    Rail<T> line{};
    for (int s = 0; s < speeds; ++s) {
      Rail<T>& one = real ? rail[s] : line;
      one = Rail<T>{};
      const SpeedTape& speed = b->speed[s];
      Tape<T>* pieces = arena.take<Tape<T>>(speed.count);
      one.piece = pieces;
      Tape<T> piece{};
      for (int i = 0; i < speed.count; ++i) {
        Tape<T>& tape = real ? pieces[i] : piece;
        tape = Tape<T>{};
        tape.place(arena, speed.pieces[i], parameters);
        tape.reads = {values + at.parameters, time, time, time, nullptr, 1.0, true};
      }
    }
  }
};

}  // namespace stickslip::inline STICKSLIP_ISA
