module bw_extended_probe
  !! A beam of pieces at one frequency in binary128: how many modes lie below, and inverse iteration to the nearest. Where a piece
  !! is next to a clamped mode of its own its ends hardly move: it is cut in parts.
  use bw_double_double, only: dd
  use bw_extended_ends, only: extended_ends
  use bw_extended_stiffness, only: extended_stiffness, find_stiffness, size_stiffness
  use bw_joint_motion, only: amplitudes_of, move_joints, stiffness_of
  use bw_kinds, only: dp, qp
  use bw_mode_probe, only: mode_probe, piece_system, probe_for, set_frequency, system_of, weigh
  use bw_piece_beam, only: cut_all, piece_beam
  use bw_piece_overlap, only: piece_modes
  use bw_piece_waves, only: is_uncounted
  implicit none (type, external)
  private
  public :: open_probe, count_at, start, improve, hold_root, keep

  integer, parameter, public :: uncounted = huge(1)    !! modes below: more than are ever asked for

  integer, parameter :: cuts = 3                   !! ways to cut the pieces: in 1, 2 and 3 parts
  real(qp), parameter :: regular_enough = 1.0e-4_qp
    !! distance from clamped modes of the pieces, 0 … 1, from which joints move enough
  real(dp), parameter :: rounding = 1.0e-29_dp     !! of stiffness, some hundred units

  type :: divided_beam
    type(piece_system) :: system
    type(mode_probe) :: probe
    type(extended_stiffness) :: stiffness
  end type divided_beam

  type, public :: extended_probe
    type(divided_beam), allocatable :: divided(:)  !! (cuts)
    integer :: parts = 1                           !! of each piece in the division that serves at this frequency
    real(qp), allocatable :: force(:, :)           !! that drives the inverse iteration, (2, 0:n·parts)
    real(dp) :: error = 0.0_dp                     !! of λ by rounding of stiffness
  end type extended_probe

contains

  pure subroutine open_probe(this, beam)
    type(extended_probe), intent(inout) :: this
    type(piece_beam), intent(in) :: beam
    integer :: c, i
    if (allocated(this%divided)) return
    allocate (this%divided(cuts))
    do c = 1, cuts
      associate (divided => this%divided(c))
        divided%system = system_of(cut_all(beam, [(c, i=1, size(beam%piece))]))
        divided%probe = probe_for(divided%system)
        call size_stiffness(c*size(beam%piece), divided%stiffness)
      end associate
    end do
  end subroutine open_probe

  pure subroutine count_at(this, x, n)
    !! Set up a frequency in the division that serves, and count the modes below; where they are `uncounted` nothing is set up.
    type(extended_probe), intent(inout) :: this
    type(dd), intent(in) :: x
    integer, intent(out) :: n
    real(qp) :: best
    integer :: c, i
    best = -1.0_qp
    n = uncounted
    do c = 1, cuts
      associate (divided => this%divided(c))
        call set_frequency(divided%system, x, divided%probe)
        if (any([(is_uncounted(divided%system%piece(i), divided%probe%frequency), i=1, size(divided%system%piece))])) return
        call find_stiffness(divided%system, divided%probe%frequency, divided%stiffness)
        if (divided%stiffness%regular > best) then
          best = divided%stiffness%regular
          this%parts = c
        end if
      end associate
      if (best > regular_enough) exit
    end do
    n = this%divided(this%parts)%stiffness%below
  end subroutine count_at

  pure subroutine start(this, number)
    !! Forces that excite every mode, one set of many: bodies are driven as much as they weigh.
    type(extended_probe), intent(inout) :: this
    integer, intent(in) :: number
    integer :: i, j
    associate (probe => this%divided(this%parts)%probe)
      if (allocated(this%force)) deallocate (this%force)
      allocate (this%force(2, 0:ubound(probe%push, 2)))
      do i = 0, ubound(probe%push, 2)
        do j = 1, 2
          this%force(j, i) = sin(real(1 + 7*number*(2*i + j)**2, dp))*probe%push(j, i)
        end do
      end do
    end associate
  end subroutine start

  pure subroutine improve(this, correction)
    !! One inverse iteration, and by how much the frequency of its mode differs.
    type(extended_probe), intent(inout) :: this
    real(dp), intent(out) :: correction
    real(qp) :: largest
    integer :: i
    associate (divided => this%divided(this%parts))
      associate (probe => divided%probe, motion => divided%stiffness%motion, unit => divided%probe%unit)
        if (size(this%force, 2) /= size(motion, 2)) call start(this, 1)
        call hold_root(divided%system, this%force)
        call move_joints(this%force, unit, divided%stiffness)
        largest = max(maxval(abs(motion)/unit(1:2, :)), real(tiny(1.0_dp), qp))
        motion = motion/largest
        this%force = this%force/largest
        probe%drive = 0.0_dp
        probe%drive(2, :, :) = real(this%force/unit(4:3:-1, :), dp)
        do i = 1, size(divided%system%piece)
          probe%amplitude(:, i) = real(amplitudes_of(divided%stiffness, i, i, divided%stiffness%outer(:, :, i)), dp)
        end do
        call weigh(divided%system, probe)
        correction = real(sum(motion*this%force), dp)/probe%mass
        this%error = rounding*real(stiffness_of(divided%stiffness), dp)/probe%mass
        this%force = motion*(probe%push/unit(1:2, :))
      end associate
    end associate
  end subroutine improve

  pure subroutine hold_root(system, force)
    !! What is held takes no force.
    type(piece_system), intent(in) :: system
    real(qp), intent(inout) :: force(:, 0:)
    if (system%beam%root%holds_deflection) force(1, 0) = 0.0_qp
    if (system%beam%root%holds_turning) force(2, 0) = 0.0_qp
  end subroutine hold_root

  pure subroutine keep(this, modes, i)
    !! The joints' motion as mode i of a set.
    type(extended_probe), intent(in) :: this
    type(piece_modes), intent(inout) :: modes
    integer, intent(in) :: i
    integer :: j
    associate (divided => this%divided(this%parts), p => this%parts)
      do j = 1, size(modes%system%piece)
        modes%amplitude(:, j, i) = real(amplitudes_of(divided%stiffness, (j - 1)*p + 1, j*p, &
                                                      extended_ends(modes%system%piece(j), divided%probe%frequency)), dp)
      end do
      modes%deflection(:, i) = real(divided%stiffness%motion(1, p::p), dp)
      modes%turning(:, i) = real(divided%stiffness%motion(2, p::p), dp)
    end associate
  end subroutine keep

end module bw_extended_probe
