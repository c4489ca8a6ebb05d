module bw_contact_law
  !! The force law of a contact: F = Kδ^p(1 + cδ̇) while the indentation δ is positive, and never negative. p = 3/2 is a
  !! Hertzian contact, p = 1 a linear stop, c the damping of Hunt and Crossley.
  !!
  !! Omitted modes respond quasi-statically, with their residual flexibility R in series with the contact. So F is
  !! solved for with δ = δ_n − RF, where δ_n is the approach of the mass and the summed modes. Units of bw_segment.
  use bw_beam_units, only: beam_units
  use bw_contact_par, only: contact_par
  use bw_force_response, only: force_degree
  use bw_force_step, only: force_step, node_slopes
  use bw_kinds, only: dp
  use bw_lapack, only: dgetrf, dgetrs
  implicit none (type, external)
  private
  public :: contact_law_of, undamped_force, solve_contact, stored_energy, contact_with_fixed_point

  type, public :: contact_law
    real(dp) :: stiffness = 0.0_dp                 !! K
    real(dp) :: exponent = 1.5_dp                  !! p ≥ 1
    real(dp) :: damping = 0.0_dp                   !! c
    real(dp) :: residual = 0.0_dp                  !! R at the struck point
  end type contact_law

contains

  pure type(contact_law) function contact_law_of(contact, units, speed) result(law)
    !! Return the law without dimensions for a given speed. The caller sets the residual flexibility.
    type(contact_par), intent(in) :: contact
    type(beam_units), intent(in) :: units
    real(dp), intent(in) :: speed                  !! |V|, m/s
    associate (unit => speed*units%time%hi)        ! m of displacements
      law%stiffness = contact%stiffness*unit**contact%exponent*(units%time%hi/(units%mass*speed))
    end associate
    law%exponent = contact%exponent
    law%damping = contact%damping*speed
  end function contact_law_of

  pure subroutine contact_with_fixed_point(law, mass_ratio, speed, indentation, force)
    !! Find the largest indentation and force of a mass striking a fixed point.
    type(contact_law), intent(in) :: law
    real(dp), intent(in) :: mass_ratio
    real(dp), intent(in) :: speed                  !! of the mass
    real(dp), intent(out) :: indentation, force
    indentation = (0.5_dp*(law%exponent + 1.0_dp)*mass_ratio*speed**2/law%stiffness)**(1.0_dp/(law%exponent + 1.0_dp))
    force = law%stiffness*indentation**law%exponent
  end subroutine contact_with_fixed_point

  pure real(dp) function stored_energy(law, indentation) result(energy)
    !! Return the recoverable energy Kδ^(p+1)/(p + 1).
    type(contact_law), intent(in) :: law
    real(dp), intent(in) :: indentation
    energy = 0.0_dp
    if (indentation > 0.0_dp) energy = law%stiffness*indentation**(law%exponent + 1.0_dp)/(law%exponent + 1.0_dp)
  end function stored_energy

  pure real(dp) function undamped_force(law, approach) result(force)
    !! Return the force of a contact without damping, F = K(δ_n − RF)^p, by bisection.
    type(contact_law), intent(in) :: law
    real(dp), intent(in) :: approach               !! δ_n
    real(dp) :: above, below, middle
    integer :: i
    force = 0.0_dp
    if (approach <= 0.0_dp) return
    below = 0.0_dp                                 ! of the indentation
    above = approach
    do i = 1, 200
      middle = 0.5_dp*(below + above)
      if (middle <= below .or. middle >= above) exit
      if (middle + law%residual*law%stiffness*middle**law%exponent < approach) then
        below = middle
      else
        above = middle
      end if
    end do
    force = law%stiffness*middle**law%exponent
  end function undamped_force

  elemental subroutine find_force(law, indentation, rate, force, by_indentation, by_rate)
    !! Return the force and its derivatives.
    type(contact_law), intent(in) :: law
    real(dp), intent(in) :: indentation, rate
    real(dp), intent(out) :: force, by_indentation, by_rate
    real(dp) :: elastic, factor
    force = 0.0_dp
    by_indentation = 0.0_dp
    by_rate = 0.0_dp
    factor = 1.0_dp + law%damping*rate
    if (indentation <= 0.0_dp .or. factor <= 0.0_dp) return
    elastic = law%stiffness*indentation**law%exponent
    force = elastic*factor
    by_indentation = law%exponent*elastic/indentation*factor
    by_rate = law%damping*elastic
  end subroutine find_force

  pure subroutine solve_contact(law, step, u, v, force, indentation, rate, converged, by_loads)
    !! Find force and indentation at the points of a step by Newton's iteration, with a new matrix if convergence is
    !! slow. In a short step the force hardly changes the motion, and the matrix is the identity.
    type(contact_law), intent(in) :: law
    type(force_step), intent(in) :: step
    real(dp), intent(in) :: u(:), v(:)             !! of all oscillators at the start
    real(dp), intent(inout) :: force(0:)           !! the first is known, the others are a guess, (0:points)
    real(dp), intent(out) :: indentation(force_degree), rate(force_degree)
    logical, intent(out) :: converged
    real(dp), intent(in), optional :: by_loads(:, :)   !! contribution of other loads to approach and rate, (points, 2)
    integer, parameter :: most = 60
    real(dp), parameter :: enough = 1.0e-11_dp     ! of the largest force; the error is smaller by `fast` or squared
    real(dp), parameter :: fast = 1.0e-2_dp        ! ratio of successive changes
    real(dp), dimension(force_degree) :: free, free_rate, law_force, by_indentation, by_rate
    real(dp), dimension(force_degree, 0:force_degree) :: compliance, rate_compliance
    real(dp) :: system(force_degree, force_degree), change(force_degree, 1), changed, before
    logical :: is_unit                             ! the matrix is nearly the identity
    integer :: i, info, iteration, pivot(force_degree)
    call step%approach(u, v, free, free_rate)
    if (present(by_loads)) then
      free = free + by_loads(:, 1)
      free_rate = free_rate + by_loads(:, 2)
    end if
    compliance = step%compliance
    rate_compliance = step%rate_compliance + law%residual/step%length*node_slopes
    do i = 1, force_degree
      compliance(i, i) = compliance(i, i) + law%residual
    end do
    converged = .false.
    before = huge(before)
    info = -1                                      ! no matrix yet
    is_unit = .false.
    do iteration = 1, most
      indentation = free - matmul(compliance, force)
      rate = free_rate - matmul(rate_compliance, force)
      if (converged) exit
      call find_force(law, indentation, rate, law_force, by_indentation, by_rate)
      if (info /= 0) then
        do i = 1, force_degree
          system(i, :) = by_indentation(i)*compliance(i, 1:) + by_rate(i)*rate_compliance(i, 1:)
        end do
        is_unit = maxval(sum(abs(system), dim=2)) <= fast
        info = 0
        if (.not. is_unit) then
          do i = 1, force_degree
            system(i, i) = system(i, i) + 1.0_dp
          end do
          call dgetrf(force_degree, force_degree, system, force_degree, pivot, info)
          if (info /= 0) return
        end if
      end if
      change(:, 1) = force(1:) - law_force
      if (.not. is_unit) call dgetrs('N', force_degree, 1, system, force_degree, pivot, change, force_degree, info)
      force(1:) = force(1:) - change(:, 1)
      changed = maxval(abs(change))
      converged = changed <= enough*maxval(abs(force)) + tiny(force)
      if (changed > fast*before) info = -1
      before = changed
    end do
    force(1:) = max(0.0_dp, force(1:))
  end subroutine solve_contact

end module bw_contact_law
