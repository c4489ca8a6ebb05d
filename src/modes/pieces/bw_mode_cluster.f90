module bw_mode_cluster
  !! Groups of modes that are too close for inverse iteration, and modes with λ = 0.
  !!
  !! The space spanned by neighbouring modes is accurate where each of them is not. Inverse iteration with as many
  !! drives as modes finds it, and the Rayleigh–Ritz method separates them: by Green's identity (bw_mode_probe) the
  !! residuals of motion b do the work H_ab = ⟨a, (λ̂ − λ)b⟩ on motion a, with λ̂ of each mode. Residuals are in
  !! binary128, so H resolves relative differences of 1e-20 in λ, though motions are in binary64. Closer modes form
  !! a cluster: any orthonormal motions that span it are its modes.
  use bw_double_double, only: dd, operator(+), operator(-), operator(*), operator(/)
  use bw_extended_residual, only: find_drive
  use bw_kinds, only: dp
  use bw_lapack, only: dsyev
  use bw_mode_probe, only: improve_drive, mode_probe, piece_system, probe_at, probe_for, respond, set_frequency, start_bodies, &
    find_modal_mass, work_of_drive
  use bw_piece_beam, only: joint_position, piece_beam
  use bw_piece_products, only: part_of, piece_product
  implicit none (type, external)
  private
  public :: find_rigid_modes, find_clustered_modes, refine_cluster

  type, public :: mode_cluster
    integer :: first = 0, last = -1                !! numbers of the modes
    type(mode_probe), allocatable :: mode(:)       !! their probes, (first:last)
  end type mode_cluster

contains

  subroutine find_clustered_modes(system, x, separation, probe, lambda)
    !! Find modes that counts cannot separate, all at one frequency.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: x                      !! near them
    real(dp), intent(in) :: separation                  !! see `refine_cluster`
    type(mode_probe), intent(out) :: probe(:)
    type(dd), intent(out) :: lambda(:)
    integer, parameter :: most_rounds = 40
    type(dd) :: before(size(lambda))
    integer :: a, round
    do a = 1, size(probe)
      probe(a) = probe_for(system)
      call set_frequency(system, x, probe(a))
      call start_bodies(a, probe(a))
    end do
    do round = 1, most_rounds
      before = lambda
      call take_apart(system, x, probe, lambda)
      if (maxval(abs(gap(lambda, before))) < separation) exit
    end do
  end subroutine find_clustered_modes

  subroutine take_apart(system, x, probe, lambda)
    !! Do one inverse iteration with every drive, and separate the modes of the space spanned.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: x                      !! frequency of the iteration
    type(mode_probe), intent(inout) :: probe(:)
    type(dd), intent(out) :: lambda(:)             !! ascending
    real(dp) :: h(size(probe), size(probe)), theta(size(probe)), work(4*size(probe))
    integer :: a, b, info
    do a = 1, size(probe)
      call probe_at(system, x, probe(a))
      call respond(system, probe(a))
      call orthogonalize(system, probe(:a))
    end do
    do a = 1, size(probe)
      call find_drive(system, probe(a))
      call find_modal_mass(system, probe(a))
    end do
    do b = 1, size(probe)
      do a = 1, size(probe)
        h(a, b) = sum(work_of_drive(probe(a), probe(b)))
      end do
    end do
    h = 0.5_dp*(h + transpose(h))                  ! they differ by the square of the residuals
    call dsyev('V', 'U', size(h, 1), h, size(h, 1), theta, work, size(work), info)
    if (info /= 0) theta = 0.0_dp                  ! for NaN; the counts of modes show the failure
    call mix(system, h, probe)
    do a = 1, size(probe)
      lambda(a) = x + theta(a)
      call improve_drive(probe(a))
    end do
  end subroutine take_apart

  subroutine refine_cluster(system, separation, probe, lambda)
    !! Repeat this with each neighbour at its own frequency, and make them mutually orthogonal.
    type(piece_system), intent(in) :: system
    real(dp), intent(in) :: separation
      !! distance in λ above which modes have frequencies of their own; one frequency serves all closer ones
    type(mode_probe), intent(inout) :: probe(:)
    type(dd), intent(inout) :: lambda(:)
    integer, parameter :: rounds = 4               ! the error is squared in each
    integer :: first, last, round
    do round = 1, rounds
      last = 0
      do while (last < size(probe))
        first = last + 1
        do last = first, size(probe) - 1
          if (gap(lambda(last + 1), lambda(last)) > separation) exit
        end do
        call take_apart(system, lambda(first) + (-2.0_dp*gap(lambda(last), lambda(first))), probe(first:last), lambda(first:last))
        call purify(system, lambda, first, last, probe)
      end do
    end do
    do first = 1, size(probe)
      call set_frequency(system, lambda(first), probe(first))
    end do
  end subroutine refine_cluster

  pure subroutine purify(system, lambda, first, last, probe)
    !! Remove components of other modes from some motions, as shown by their residuals.
    type(piece_system), intent(in) :: system
    type(dd), intent(in) :: lambda(:)
    integer, intent(in) :: first, last             !! of those
    type(mode_probe), intent(inout) :: probe(:)
    real(dp) :: share(size(probe))
    integer :: a, b
    share = 0.0_dp
    do a = first, last
      call find_drive(system, probe(a))
      do b = 1, size(probe)
        if (b >= first .and. b <= last) cycle
        share(b) = sum(work_of_drive(probe(b), probe(a)))/(gap(lambda(b), probe(a)%frequency%lambda)*probe(b)%mass)
      end do
      do b = 1, size(probe)
        call add(probe(b), -share(b), probe(a))
      end do
      call find_drive(system, probe(a))
      call find_modal_mass(system, probe(a))
      call improve_drive(probe(a))
    end do
  end subroutine purify

  elemental real(dp) function gap(a, b)
    !! Return a − b.
    type(dd), intent(in) :: a, b
    type(dd) :: difference
    difference = a - b
    gap = difference%hi
  end function gap

  pure subroutine mix(system, share, probe)
    !! Combine motions at the same frequency.
    type(piece_system), intent(in) :: system
    real(dp), intent(in) :: share(:, :)
    type(mode_probe), intent(inout) :: probe(:)
    type(mode_probe) :: given(size(probe))
    integer :: a, b
    given = probe
    do a = 1, size(probe)
      call multiply(share(a, a), probe(a))
      do b = 1, size(probe)
        if (b /= a) call add(given(b), share(b, a), probe(a))
      end do
      call find_modal_mass(system, probe(a))
    end do
  end subroutine mix

  pure subroutine multiply(factor, probe)
    real(dp), intent(in) :: factor
    type(mode_probe), intent(inout) :: probe
    probe%amplitude = factor*probe%amplitude
    probe%drive = factor*probe%drive
    probe%motion = factor*probe%motion
  end subroutine multiply

  pure subroutine add(other, share, probe)
    !! Add a multiple of another motion.
    type(mode_probe), intent(in) :: other
    real(dp), intent(in) :: share
    type(mode_probe), intent(inout) :: probe
    probe%amplitude = probe%amplitude + share*other%amplitude
    probe%drive = probe%drive + share*other%drive
    probe%motion = probe%motion + share*other%motion
  end subroutine add

  pure subroutine orthogonalize(system, probe)
    !! Orthogonalise the last motion to those before, and scale it to mass 1.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(inout) :: probe(:)
    integer, parameter :: rounds = 2
    integer :: b, n, round
    n = size(probe)
    do round = 1, rounds
      do b = 1, n - 1
        call add(probe(b), -mass_product(system, probe(n), probe(b)), probe(n))
      end do
      call find_modal_mass(system, probe(n))
      call multiply(1.0_dp/sqrt(mass_product(system, probe(n), probe(n))), probe(n))
    end do
    call find_modal_mass(system, probe(n))
  end subroutine orthogonalize

  pure real(dp) function mass_product(system, one, other) result(product)
    !! Return the product of two motions weighted by all mass and inertia.
    type(piece_system), intent(in) :: system
    type(mode_probe), intent(in) :: one, other
    integer :: i
    product = 0.0_dp
    do i = 1, size(system%piece)
      associate (piece => system%piece(i), joint => system%beam%joint(i))
        product = product + piece_product(piece, part_of(piece, one%frequency, one%amplitude(:, i)), &
                                          part_of(piece, other%frequency, other%amplitude(:, i))) &
          + joint%mass%hi*one%motion(1, i)*other%motion(1, i) + joint%inertia%hi*one%motion(2, i)*other%motion(2, i)
      end associate
    end do
  end function mass_product

  pure subroutine find_rigid_modes(system, first, last, cluster)
    !! Find the modes known to have λ = 0: the beam moves as a whole, or rotates about its centre of mass or its support.
    type(piece_system), intent(in) :: system       !! of pieces that are short at λ = 0
    integer, intent(in) :: first, last             !! their numbers
    type(mode_cluster), intent(out) :: cluster
    type(dd) :: middle, pivot
    integer :: i, k
    logical :: turns
    cluster%first = first
    cluster%last = last
    allocate (cluster%mode(first:last))
    pivot = pivot_of(system%beam)
    do k = first, last
      associate (probe => cluster%mode(k))
        probe = probe_for(system)
        call set_frequency(system, dd(), probe)
        probe%amplitude = 0.0_dp
        turns = k > first .or. .not. moves_freely(system%beam)
        do i = 1, size(system%piece)
          middle = joint_position(system%beam, i) - system%piece(i)%half - pivot
          probe%amplitude(1, i) = merge(middle%hi, 1.0_dp, turns)/probe%frequency%unit(1)
          if (turns) probe%amplitude(3, i) = 1.0_dp/probe%frequency%unit(2)
        end do
        probe%drive = 0.0_dp
        call find_modal_mass(system, probe)
      end associate
    end do
  end subroutine find_rigid_modes

  pure logical function moves_freely(beam)
    !! Return whether deflection is free.
    type(piece_beam), intent(in) :: beam
    moves_freely = .not. (beam%root%holds_deflection .or. beam%root%stiffness%hi > 0.0_dp &
                          .or. any(beam%joint%stiffness%hi > 0.0_dp))
  end function moves_freely

  pure type(dd) function pivot_of(beam) result(pivot)
    !! Return the fixed point of a freely rotating beam: its support, else its centre of mass.
    type(piece_beam), intent(in) :: beam
    type(dd) :: outer, mass, own
    integer :: i
    if (beam%root%holds_deflection .or. beam%root%stiffness%hi > 0.0_dp) return
    do i = 1, size(beam%piece)
      outer = joint_position(beam, i)
      own = beam%piece(i)%mass*beam%piece(i)%length
      pivot = pivot + own*(outer - beam%piece(i)%length*0.5_dp) + beam%joint(i)%mass*outer
      mass = mass + own + beam%joint(i)%mass
    end do
    pivot = pivot/mass
    do i = 1, size(beam%piece)
      if (beam%joint(i)%stiffness%hi > 0.0_dp) pivot = joint_position(beam, i)
    end do
  end function pivot_of

end module bw_mode_cluster
