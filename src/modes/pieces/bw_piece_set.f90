module bw_piece_set
  !! Modes of a beam of uniform pieces: shapes at points, and what they see of a motion written in the modes of the same
  !! beam with another body.
  !!
  !! Shapes have ∫Φ² dξ = 1 of the beam's part and a tip value of sign (−1)^k. The modal mass holds all mass and inertia:
  !! M_k = ∫ρAΦ² + ρIΨ² dx + Σ mΦ² + JΨ², Ψ the turning of the sections.
  use bw_double_double, only: dd, operator(+), operator(*)
  use bw_kinds, only: dp
  use bw_mode_probe, only: piece_system
  use bw_mode_set, only: mode_set
  use bw_monitor, only: monitor_type
  use bw_piece_overlap, only: overlap_sums, piece_modes
  use bw_piece_shape, only: beam_place, place_of, states_inside
  use bw_piece_waves, only: frequency_at, piece_frequency
  implicit none (type, external)
  private

  type, extends(mode_set), public :: piece_set
    type(piece_modes) :: modes                   !! from which shapes follow
    real(dp), allocatable :: spun(:)             !! part of M_k on which the spin acts: translations in plane, turning out of it, (n)
  contains
    procedure :: states => states_at
    procedure :: some_shapes => piece_shapes
    procedure :: some_curvatures => piece_curvatures
    procedure :: overlap_with_mass
    procedure :: overlap_of_beam
    procedure :: elastic => piece_elastic
  end type piece_set

contains

  pure function states_at(self, first, last, xi) result(state)
    !! Deflection, turning, moment M = EIψ' and shear force N = κGA(v' − ψ) of modes `first` … `last` at points of the beam.
    class(piece_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)                !! 0 ≤ ξ ≤ 1, (points)
    real(dp) :: state(4, last - first + 1, size(xi))
    type(beam_place) :: place(size(xi))
    type(piece_frequency) :: frequency
    integer :: k, p
    do p = 1, size(xi)
      place(p) = place_of(self%modes%system%beam, xi(p))
    end do
    do k = first, last
      frequency = frequency_at(self%modes%system%beam, self%modes%lambda(k))
      do p = 1, size(xi)
        associate (i => place(p)%piece)
          state(:, k - first + 1, p:p) = states_inside(self%modes%system%piece(i), frequency, &
                                                       self%modes%amplitude(:, i, k), [place(p)%offset])
        end associate
      end do
    end do
    if (.not. self%modes%system%beam%root%holds_deflection) return
    do p = 1, size(xi)
      if (xi(p) == 0.0_dp) state(1, :, p) = 0.0_dp
    end do
  end function states_at

  pure function piece_shapes(self, first, last, xi) result(values)
    class(piece_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    real(dp) :: state(4, last - first + 1, size(xi))
    state = self%states(first, last, xi)
    values = state(1, :, :)
  end function piece_shapes

  pure function piece_curvatures(self, first, last, xi) result(values)
    !! The moment over EI; at a joint that of the piece inside it.
    class(piece_set), intent(in) :: self
    integer, intent(in) :: first, last
    real(dp), intent(in) :: xi(:)
    real(dp) :: values(last - first + 1, size(xi))
    real(dp) :: state(4, last - first + 1, size(xi))
    integer :: p
    state = self%states(first, last, xi)
    do p = 1, size(xi)
      associate (place => place_of(self%modes%system%beam, xi(p)))
        values(:, p) = state(3, :, p)/self%modes%system%beam%piece(place%piece)%stiffness%hi
      end associate
    end do
  end function piece_curvatures

  function overlap_with_mass(self, from, amplitude, monitor) result(sums)
    class(piece_set), intent(in) :: self
    class(mode_set), intent(in) :: from          !! of the same pieces, springs and joints
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor     ! not asked yet
    real(dp) :: sums(self%count)
    select type (from)
    class is (piece_set)
      sums = overlap_sums(self%modes, from%modes, amplitude, .true.)
      if (present(monitor)) continue
    class default
      error stop 'bw_piece_set: modes found in different ways have no overlap'
    end select
  end function overlap_with_mass

  function overlap_of_beam(self, from, amplitude, monitor) result(sums)
    class(piece_set), intent(in) :: self
    class(mode_set), intent(in) :: from          !! of the same pieces, springs and joints
    real(dp), intent(in) :: amplitude(:)
    class(monitor_type), intent(inout), optional :: monitor     ! not asked yet
    real(dp) :: sums(self%count)
    select type (from)
    class is (piece_set)
      sums = overlap_sums(self%modes, from%modes, amplitude, .false.)
      if (present(monitor)) continue
    class default
      error stop 'bw_piece_set: modes found in different ways have no overlap'
    end select
  end function overlap_of_beam

  pure function piece_elastic(self) result(squares)
    !! All stiffness, that of springs too: β² and what the spin takes from it.
    class(piece_set), intent(in) :: self
    type(dd) :: squares(self%count)
    squares = self%beta_squared + self%modes%system%beam%spin_squared*(self%spun/self%modal_mass)
  end function piece_elastic

end module bw_piece_set
