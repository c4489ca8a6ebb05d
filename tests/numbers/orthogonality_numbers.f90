module orthogonality_numbers
  !! Orthogonality (Eq. 21) of two thousand modes, by quadrature of the shape routine.
  use bw_kinds, only: dp
  use bw_closed_form, only: closed_form_modes, closed_form_set
  use bw_text, only: text_of
  use gauss_legendre, only: panel_rule
  use number_table, only: table_type
  implicit none (type, external)
  private
  public :: measure_orthogonality

  integer, parameter :: modes = 2000
  integer, parameter :: order = 64              !! nodes of a panel
  integer, parameter :: panels = modes/20       !! two modes together turn 20 times in a panel: exact to rounding
  integer, parameter :: batch = 10*order        !! nodes taken at a time: their shapes stay in the cache
  real(dp), parameter :: mass_ratios(3) = [0.0_dp, 0.2_dp, 1.0e6_dp]
  character(*), parameter :: names(3) = [character(3) :: '0', '0.2', '1e6']

  interface
    subroutine dsyrk(uplo, trans, n, k, alpha, a, lda, beta, c, ldc)
      import :: dp
      implicit none (type, external)
      character, intent(in) :: uplo, trans
      integer, intent(in) :: n, k, lda, ldc
      real(dp), intent(in) :: alpha, beta, a(lda, *)
      real(dp), intent(inout) :: c(ldc, *)
    end subroutine dsyrk
  end interface

contains

  subroutine measure_orthogonality(table)
    !! ∫Φ_kΦ_i dξ + γΦ_k(1)Φ_i(1) is M_k for i = k, else 0.
    type(table_type), intent(inout) :: table
    type(closed_form_set) :: set
    real(dp), allocatable :: gram(:, :)
    integer :: g, k
    do g = 1, size(mass_ratios)
      call table%begin('orthogonality (Eq. 21) of '//text_of(modes)//' modes by quadrature, γ = '// &
                       trim(names(g)), 1.0e-12_dp, 'absolute')
      set = closed_form_modes(modes, mass_ratios(g))
      allocate (gram, source=beam_part(set))
      do k = 1, modes
        gram(:k, k) = gram(:k, k) + set%gamma*set%struck(:k)*set%struck(k)
        gram(k, k) = gram(k, k) - set%modal_mass(k)
        call table%note(abs(gram(:k, k)))
      end do
      deallocate (gram)
    end do
  end subroutine measure_orthogonality

  function beam_part(set) result(gram)
    !! ∫Φ_kΦ_i dξ, the upper triangle.
    type(closed_form_set), intent(in) :: set
    real(dp) :: gram(modes, modes)
    real(dp), allocatable :: nodes(:), weights(:), values(:, :)
    integer :: first, n
    call panel_rule(panels, order, nodes, weights)
    gram = 0.0_dp
    do first = 1, size(nodes), batch
      values = set%shapes(nodes(first:first + batch - 1))
      do n = 1, batch
        values(:, n) = values(:, n)*sqrt(weights(first + n - 1))
      end do
      call dsyrk('U', 'N', modes, batch, 1.0_dp, values, modes, 1.0_dp, gram, modes)
    end do
  end function beam_part

end module orthogonality_numbers
